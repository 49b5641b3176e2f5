"""Chambers that proportional valves feed: what makes regulators of valves, sensors and rods."""
