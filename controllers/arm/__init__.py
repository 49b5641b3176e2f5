"""A U-R-S arm: kinematics, singularity-consistent laws and the laws that they are held against."""
