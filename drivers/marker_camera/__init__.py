"""Cameras that watch markers: sources of frames, detectors, and the driver."""
