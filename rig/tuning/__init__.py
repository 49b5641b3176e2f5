"""Gains for a rig, from what is known of it and of how well: `rig tune`."""
