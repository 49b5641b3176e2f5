"""What a calibrated driver makes of an encoder, for devices that have no driver (`--on sim`).

The device is wired as its maker says; the calibration is what the driver knows beyond that. On
a bus the two meet in counts; here they meet in straight lines between lengths.
"""

from drivers.cia406.settings import Cia406Settings
from drivers.sim.direct.encoders import RodPort
from drivers.sim.wiring import Installed


class CorrectedRods(RodPort):
    """The rod of a plant, as calibrated settings have it.

    Parameters
    ----------
    plant : RodPort
        The physics.
    scale, offset : float
        Of what the driver reads over what it would read uncalibrated, 1 and m.
    """

    def __init__(self, plant: RodPort, scale: float, offset: float) -> None:
        self._plant = plant
        self._scale = scale
        self._offset = offset

    @classmethod
    def of(cls, of: Installed[Cia406Settings, RodPort]) -> "CorrectedRods":
        """Return the port of an encoder."""
        nominal, settings = of.built, of.settings
        sign = -1.0 if nominal.reversed != settings.reversed else 1.0
        # The emulated device counts from the nominal offset on, see `emulate_cia406`.
        scale = sign * settings.scale / nominal.scale
        return cls(of.plant, scale, settings.offset - scale * nominal.offset)

    def position(self, channel: int) -> float:
        """Return the extension that the driver reads, m."""
        return self._scale * self._plant.position(channel) + self._offset

    def speed(self, channel: int) -> float:
        """Return the speed that the driver reads, m/s."""
        return self._scale * self._plant.speed(channel)
