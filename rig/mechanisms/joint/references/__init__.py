"""Motions that an experiment may ask of the spherical joint."""
