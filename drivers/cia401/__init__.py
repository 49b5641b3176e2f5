"""Drivers of electro-pneumatic pressure regulators."""
