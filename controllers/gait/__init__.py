"""Statically balanced walking on two six-joint legs whose knees pass the straight position."""
