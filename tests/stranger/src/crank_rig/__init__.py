"""A crank rig and three devices of one lab, for a program that knows nothing of them."""
