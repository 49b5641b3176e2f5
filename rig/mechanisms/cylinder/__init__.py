"""One antagonistic pair of pneumatic cylinders."""
