"""Steps of the acceptance test that all mechanisms with pneumatic cylinders share."""
