"""A control law for an antagonistic pair of cylinders."""
