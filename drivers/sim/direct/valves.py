"""Simulated proportional valves with chamber sensors; see `drivers.sim.direct.device`."""

from collections.abc import Sequence

from drivers.sim.direct.chambers import SimulatedChambers
from drivers.sim.valve_port import ValvePort
from rig.hal import Clock, LimitExceeded, ProportionalValves, Vector

_EXHAUSTED = -1.0


class SimulatedValves(SimulatedChambers, ProportionalValves):
    """Valves, e-stop contact and supply valve of a plant; faults as `SimulatedChambers` has them.

    Parameters
    ----------
    name, channels, clock, resolution
        See `SimulatedChambers`.
    plant : ValvePort
        The physics.
    opening_range : tuple of float
        Of the openings.
    sensor_range : tuple of float
        Pressures that the sensors show, Pa gauge.
    """

    def __init__(
        self,
        name: str,
        channels: Sequence[str],
        plant: ValvePort,
        clock: Clock,
        *,
        opening_range: tuple[float, float] = (-1.0, 1.0),
        sensor_range: tuple[float, float] = (0.0, 0.5e6),
        resolution: float = 0.5e6 / 0x7FFF,
    ) -> None:
        super().__init__(name, channels, plant, clock, resolution)
        self.sensor_range = sensor_range
        self._range = opening_range
        self._plant = plant
        self._exhausted = self._opening = (_EXHAUSTED,) * len(self.channels)
        self.log_columns = self.opening_columns()

    def log_values(self) -> tuple[float, ...]:
        """Return the openings that were sent; see `Device.log_values`."""
        return self._opening

    def connect(self) -> None:
        """Exhaust, with the supply closed, and take the first readings."""
        self.make_safe()
        self._was_stopped = self._stopped
        self._sample()

    def arm(self) -> None:
        """Open the supply and follow openings from now on."""
        self._armed = True
        self._plant.set_supply(True)
        self._sample()

    def set_opening(self, opening: Vector) -> None:
        """Take openings for this cycle, -1 … 1, shape (n,); ignored unless armed.

        Raises
        ------
        LimitExceeded
            An opening is outside the range or not a number. The openings stay as they were.
        """
        if not self._armed or self._is_silent():
            return
        low, high = self._range
        for channel, value in zip(self.channels, opening, strict=True):
            if not low <= value <= high:
                raise LimitExceeded(f"{self.name}: setpoint of {channel}", value, low, high, "")
        self._open(opening)

    def make_safe(self) -> None:
        """Move all spools to their exhausts and shut the supply."""
        self._armed = False
        self._plant.set_supply(False)
        self._open(self._exhausted)

    def unsafe(self, now: float) -> str:
        """Return which chambers are not vented, as they are measured now."""
        self._sample()
        return super().unsafe(now)

    def _open(self, opening: Vector) -> None:
        self._opening = opening
        self._write(opening)

    def _put_out(self, channel: int, setpoint: float) -> None:
        self._plant.set_opening(channel, setpoint)
