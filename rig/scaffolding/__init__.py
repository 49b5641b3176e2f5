"""Files to begin with: an experiment, a rig, a control law or a driver of one's own."""
