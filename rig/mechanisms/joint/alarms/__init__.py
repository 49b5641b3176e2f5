"""What tells that something of the spherical joint is broken, and what it is, by name.

Everything is judged from what the rig measures: rods, pressures, camera. Where two causes look
the same, the message says both.
"""
