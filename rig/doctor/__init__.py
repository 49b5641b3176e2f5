"""What a computer needs to run a rig on hardware, looked at without touching the rig."""
