"""Pure controllers: no I/O, clock, log or randomness."""
