"""Emulated CANopen nodes, of their own making: they share no codec with the drivers."""
