"""What the mechanisms on pneumatic cylinders share."""
