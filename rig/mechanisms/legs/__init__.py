"""Two six-joint walking legs on servo drives."""
