"""Drivers of linear encoders."""
