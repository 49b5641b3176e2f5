"""From the settings of load cells to their simulated forms."""

from collections.abc import Callable

from drivers.load_cells.settings import PROFILE, LoadCell, LoadCellSettings
from drivers.sim.direct.body_sensors import SimulatedLoadCells
from drivers.sim.nodes.base import VENDOR_ID
from drivers.sim.nodes.described import EmulatedDescribed, NodeBuild, ObjectBuild
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock, MeasuredPlant

Cells = Installed[LoadCellSettings, MeasuredPlant]


def emulate_load_cells(of: Cells) -> tuple[EmulatedDescribed]:
    """Return an emulated CiA 401 module with the cells on its analogue inputs."""
    cells = list(of.built.cells.values())
    objects = [
        ObjectBuild(cell.index, cell.sub, cell.type, 0, False, "t", _counts(of, cell, channel))
        for cell, channel in zip(cells, of.channels, strict=True)
    ]
    sent = tuple(tuple(entry.code for entry in layout) for layout in of.built.layouts)
    build = NodeBuild(PROFILE, VENDOR_ID, 401, of.serial or 0, tuple(objects), (), sent)
    return (EmulatedDescribed(of.name, of.built.node, build),)


def _counts(of: Cells, cell: LoadCell, channel: int) -> Callable[[], float]:
    """Return what a cell's converter makes of the force on it; its ends are where it stops."""
    (low, high), (weak, strong) = cell.raw, cell.force

    def counts() -> float:
        force = of.plant.channel_value(channel) + cell.zero
        share = (force - weak) / (strong - weak)
        return min(max(low + share * (high - low), low), high)

    return counts


def simulate_load_cells(of: Cells, clock: Clock) -> SimulatedLoadCells:
    """Return simulated cells with the resolution of the wired ones."""
    cells = of.settings.cells
    steps = [abs((c.force[1] - c.force[0]) / (c.raw[1] - c.raw[0])) for c in cells.values()]
    device = SimulatedLoadCells(
        of.name, of.plant, of.channels, steps, of.settings.frozen_timeout, clock
    )
    device.channels = tuple(cells)
    return device


WIRING = Wiring(emulate_load_cells, simulate_load_cells)
