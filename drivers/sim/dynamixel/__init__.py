"""Emulated Dynamixel X-series servos: a chain on a serial line, of its own making.

Written from the maker's manual, not from the driver: the two share no code, so that a mistake
in one shows against the other, and both are checked by the maker's own library.
"""
