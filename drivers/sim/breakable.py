"""Faults by name: what each does, and what undoes it."""

from collections.abc import Callable
from math import inf

FaultAction = Callable[[float | None], None]
"""Makes a fault happen, with the value that it was given, SI."""


class Breakable:
    """Base of the simulated devices that can be broken on purpose; ``repair`` ends what lasts."""

    name: str  # of the device, which provides it

    def __init__(self) -> None:
        self._faults: dict[str, FaultAction] = {}
        self._repairs: list[Callable[[], None]] = []

    def add_fault(
        self, fault: str, action: FaultAction, repair: Callable[[], None] | None = None
    ) -> None:
        """Make a fault known by name, with what undoes it."""
        self._faults[fault] = action
        if repair is not None:
            self._repairs.append(repair)

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return (*self._faults, "repair")

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Parameters
        ----------
        fault : str
            One of `known_faults`.
        value : float, optional
            What the fault's description says.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault == "repair":
            self.repair()
        elif fault in self._faults:
            self._faults[fault](value)
        else:
            known = ", ".join(self.known_faults)
            raise ValueError(f"{self.name}: no fault {fault!r}; known are {known}")

    def repair(self) -> None:
        """End all faults that last."""
        for repair in self._repairs:
            repair()

    def lasting_time(self, fault: str, value: float | None) -> float:
        """Return for how long a fault lasts that takes a time or none, s.

        Raises
        ------
        ValueError
            The time is not positive.
        """
        if value is not None and not value > 0.0:
            raise ValueError(f"{self.name}: {fault} lasts longer than {value:g} s")
        return inf if value is None else value
