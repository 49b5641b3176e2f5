"""Everything that the driver of CiA 410 inclinometers offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.cia410.settings:Cia410Settings",
    device="drivers.cia410.device:Cia410Sensor",
    simulation="drivers.sim.nodes.cia410_wiring:WIRING",
)
