"""What the drives have to give: masses, friction and payload, and the torques along a motion."""
