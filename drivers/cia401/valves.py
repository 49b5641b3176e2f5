"""Proportional valves and chamber sensors behind a CiA 401 analogue module."""

from drivers.canopen.bus import CanopenBus
from drivers.cia401.module import AnalogueModule
from drivers.cia401.valve_settings import EXHAUSTED, Cia401ValvesSettings
from rig.hal import ProportionalValves, Vector


class Cia401Valves(AnalogueModule, ProportionalValves):
    """Spools, chamber sensors, emergency-stop contact and supply valve on one CiA 401 node.

    Safe is: every spool at its exhaust, the supply shut. A module that is stopped, reset or out of
    its heartbeat takes the same by its error values.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = Cia401ValvesSettings

    def __init__(
        self,
        name: str,
        settings: Cia401ValvesSettings,
        bus: CanopenBus,
        *,
        serial: int | None = None,
    ) -> None:
        self.settings = settings
        self.sensor_range = settings.sensor_range
        count = len(settings.channels)
        super().__init__(
            name,
            settings,
            bus,
            serial,
            span=settings.opening_range,
            unit="",
            safe=(EXHAUSTED,) * count,
            held=(False,) * count,
        )
        self.log_columns = self.opening_columns()

    def log_values(self) -> tuple[float, ...]:
        """Return the openings that were sent; see `Device.log_values`."""
        return self._setpoint

    def set_opening(self, opening: Vector) -> None:
        """Take openings for this cycle, shape (n,); ignored unless armed.

        Raises
        ------
        LimitExceeded
            An opening is outside the range or not a number. The openings stay as they were.
        ValueError
            There is not one opening per channel.
        """
        self._give(opening)

    def unsafe(self, now: float) -> str:
        """Return which chambers are not known to be vented; see `Device.unsafe`."""
        self._ask_monitors()
        return self._wires.explain(super().unsafe(now))
