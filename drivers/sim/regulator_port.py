"""What simulated regulators need of a plant."""

from typing import Protocol


class RegulatorPort(Protocol):
    """Regulators, the valves to their chambers, and their supply."""

    def set_pressure_setpoint(self, channel: int, pressure: float) -> None:
        """Give a regulator its setpoint, Pa gauge."""

    def pressure(self, channel: int) -> float:
        """Return what a regulator's monitor shows, Pa gauge."""

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""

    def set_lock(self, channel: int, locked: bool) -> None:
        """Shut or open the valve between a regulator and its chamber."""
