"""The acceptance test of a physical rig."""
