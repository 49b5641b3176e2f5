"""Everything that the driver of regulators behind CiA 401 modules offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.cia401.settings:Cia401Settings",
    device="drivers.cia401.device:Cia401Regulators",
    simulation="drivers.sim.nodes.cia401_wiring:WIRING",
)
