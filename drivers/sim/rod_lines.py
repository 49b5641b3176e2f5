"""Rods of a plant as something sees them whose lengths lie on other straight lines."""

from collections import defaultdict
from collections.abc import Mapping

from drivers.cia406.settings import Cia406Settings
from drivers.sim.direct.encoders import RodPort
from drivers.sim.perturbation import Draws, Line
from drivers.sim.wiring import Installed


class RodLines(RodPort):
    """Rods whose extensions are seen on straight lines.

    Parameters
    ----------
    plant : RodPort
        The physics.
    lines : mapping of int to tuple of float
        Gain and offset by the plant's channel, 1 and m.
    """

    def __init__(self, plant: RodPort, lines: Mapping[int, Line]) -> None:
        self._plant = plant
        self._lines = lines

    def position(self, channel: int) -> float:
        """Return the extension that is seen, m."""
        gain, offset = self._lines[channel]
        return gain * float(self._plant.position(channel)) + offset

    def speed(self, channel: int) -> float:
        """Return the speed that is seen, m/s."""
        return self._lines[channel][0] * float(self._plant.speed(channel))


def correct_rods(of: Installed[Cia406Settings, RodPort]) -> RodLines:
    """Return the rods as calibrated settings have them; see `drivers.sim.wiring.Wiring`."""
    nominal, settings = of.built, of.settings
    sign = -1.0 if nominal.reversed != settings.reversed else 1.0
    # The emulated device counts from the nominal offset on, see `emulate_cia406`.
    gain = sign * settings.scale / nominal.scale
    line = gain, settings.offset - gain * nominal.offset
    return RodLines(of.plant, defaultdict(lambda: line))  # whichever rod it is mounted on


def perturb_rods(plant: RodPort, draws: Draws) -> RodLines:
    """Return rods whose encoders err in scale and offset, as a seed draws it."""
    return RodLines(plant, draws.lines("encoder_scale", "encoder_offset"))
