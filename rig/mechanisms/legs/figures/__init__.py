"""Figures of the walking legs."""
