"""The simulated rig: virtual time, emulated bus nodes, capability-level devices and plants."""
