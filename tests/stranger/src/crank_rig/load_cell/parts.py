"""Everything that the driver of the load cell offers to the program: no simulation of its own."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="crank_rig.load_cell.settings:LoadCellSettings",
    device="crank_rig.load_cell.device:LoadCell",
)
