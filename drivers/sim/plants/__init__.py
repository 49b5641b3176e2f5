"""What the simulated rigs are made of: physics only, no protocol and no device."""
