"""Files to begin with: an experiment, a rig, a law, a driver or a mechanism of one's own."""
