"""What simulated proportional valves need of a plant."""

from typing import Protocol


class ValvePort(Protocol):
    """Spool valves, the pressure sensors at their chambers, and their supply."""

    def set_opening(self, channel: int, opening: float) -> None:
        """Give a spool its signal, -1 (exhaust) … 1 (feed)."""

    def pressure(self, channel: int) -> float:
        """Return what a chamber's sensor shows, Pa gauge."""

    def set_supply(self, open: bool) -> None:
        """Open or shut (and vent) the supply valve."""
