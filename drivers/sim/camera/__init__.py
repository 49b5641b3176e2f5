"""Simulated marker cameras: a renderer of its own making, and cameras with and without images.

Nothing here uses the detector's geometry: the lens, the pose and the marker are computed a
second time, another way, so that a mistake in one side shows against the other.
"""
