"""Everything that the driver of CiA 406 linear encoders offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.cia406.settings:Cia406Settings",
    device="drivers.cia406.device:Cia406Encoder",
    simulation="drivers.sim.nodes.cia406_wiring:WIRING",
)
