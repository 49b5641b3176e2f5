"""Measures of the spherical joint."""
