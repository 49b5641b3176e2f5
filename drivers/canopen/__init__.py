"""CANopen: what all drivers on such a bus share."""
