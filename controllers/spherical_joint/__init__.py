"""The wide-angle spherical joint: kinematics, tensions, pose control and estimation."""
