"""Everything that the driver of load cells offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.load_cells.settings:LoadCellSettings",
    device="drivers.load_cells.device:CanopenLoadCells",
    simulation="drivers.sim.nodes.load_cells_wiring:WIRING",
)
