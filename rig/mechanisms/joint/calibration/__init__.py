"""Camera and geometry of the spherical joint, from what encoders and camera say of one motion."""
