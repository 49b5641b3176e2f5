"""Motions that calibrate the axes of servo drives."""
