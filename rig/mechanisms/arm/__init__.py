"""A six-joint U-R-S arm on servo drives."""
