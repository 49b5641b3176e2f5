"""What a motion costs, by name: every run of a pneumatic mechanism reports it."""

REPORTED = ("air_used", "valve_reversals", "setpoint_rate", "setpoint_range")
