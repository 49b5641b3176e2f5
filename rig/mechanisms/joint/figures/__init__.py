"""Figures of the spherical joint."""
