"""Procedures that only a single pair has."""
