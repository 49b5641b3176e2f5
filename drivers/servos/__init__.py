"""Servo drives, n joints per device: each driver satisfies `rig.hal.ServoBus`."""
