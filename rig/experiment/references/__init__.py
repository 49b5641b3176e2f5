"""Desired motions, as experiments name them; one module per kind of rig."""
