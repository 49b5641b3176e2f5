"""Steps that any rig has, whatever it moves."""
