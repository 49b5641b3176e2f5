"""Experiments from Python: what ``import rig`` offers."""
