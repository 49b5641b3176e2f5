"""Emulated nodes on a CAN bus, of their own making: they share no codec with the drivers."""
