"""What tells that a pneumatic mechanism is broken, whichever one it is."""
