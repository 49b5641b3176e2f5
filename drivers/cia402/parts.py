"""Everything that the driver of axes on CiA 402 drives offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.cia402.settings:Cia402Settings",
    device="drivers.cia402.device:Cia402Servos",
    simulation="drivers.sim.nodes.cia402_wiring:WIRING",
)
