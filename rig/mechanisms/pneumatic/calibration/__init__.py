"""Procedures for regulators, encoders and wires of pneumatic cylinders."""
