"""Inclinometers with gyroscopes after CiA 410."""
