"""Which causes explain the last second before a fault best, found once the rig was made safe.

Each hypothesis (a slow or late regulator, one that is stuck, a leak, a low supply, a monitor that
is off, other friction, softer wires) is fitted by a bounded scan, and pays for its parameters.
"""
