"""Position controllers for one antagonistic pair of pneumatic cylinders."""
