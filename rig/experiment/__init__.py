"""What to do with a rig: references, the run, and what it measured."""
