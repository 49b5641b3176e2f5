"""From the settings of a CiA 406 encoder to its simulated forms."""

from drivers.cia406.settings import Cia406Settings
from drivers.sim.direct.encoders import RodPort, SimulatedEncoder
from drivers.sim.nodes.cia406 import EmulatedCia406
from drivers.sim.rod_lines import correct_rods, perturb_rods
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock


def emulate_cia406(of: Installed[Cia406Settings, RodPort]) -> tuple[EmulatedCia406]:
    """Return an emulated CiA 406 encoder, mounted as the driver's settings say."""
    settings = of.built
    # The driver reads ±scale·counts·step + offset as the extension: the device counts what
    # makes that true of a rod that the calibration described rightly.
    node = EmulatedCia406(
        of.name,
        settings.node,
        of.plant,
        of.channels[0],
        stroke=settings.stroke,
        step=settings.step or 1e-6,
        speed_step=settings.speed_step or 1e-5,
        offset=-settings.offset / settings.scale,
        reversed_direction=settings.reversed,
        serial=of.serial or 0,
    )
    return (node,)


def simulate_cia406(of: Installed[Cia406Settings, RodPort], clock: Clock) -> SimulatedEncoder:
    """Return a simulated encoder with the resolution of the real one."""
    settings = of.settings
    return SimulatedEncoder(
        of.name,
        of.channels[0],
        of.plant,
        clock,
        stroke=settings.stroke,
        resolution=settings.step or 1e-6,
        speed_resolution=settings.speed_step or 1e-5,
        max_speed=settings.max_speed,
    )


WIRING = Wiring(emulate_cia406, simulate_cia406, correct_rods, perturb_rods)
