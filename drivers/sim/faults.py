"""Faults on a schedule: what breaks, where and when."""

import difflib
from collections.abc import Mapping, Sequence
from typing import Protocol

from drivers.sim.clock import World
from rig.hal import ConfigurationError


class ScheduledFault(Protocol):
    """One line of a fault schedule, wherever it was read."""

    @property
    def at(self) -> float:
        """When, s on the rig's clock."""

    @property
    def device(self) -> str:
        """Name of the device, or ``plant``."""

    @property
    def fault(self) -> str:
        """One of the faults that it knows."""

    @property
    def size(self) -> float | None:
        """What the fault's description says, SI."""


class Faulty(Protocol):
    """Something that can be broken on purpose."""

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""


class FaultSchedule:
    """The faults of a run in the order of their times.

    Parameters
    ----------
    faults : sequence of ScheduledFault
        In any order; those of the same time happen in the order given.
    targets : mapping
        What they happen to, by name.

    Raises
    ------
    ValueError
        A fault names a target that is not there, or one that the target does not know.
    """

    def __init__(self, faults: Sequence[ScheduledFault], targets: Mapping[str, Faulty]) -> None:
        for entry in faults:
            _check(entry, targets)
        self._targets = dict(targets)
        # Taken from its end: the latest first, and of equal times the last given.
        self._waiting = sorted(faults, key=lambda entry: entry.at)[::-1]

    @property
    def next_time(self) -> float:
        """When the next fault happens, s; infinite if none is left."""
        return self._waiting[-1].at if self._waiting else float("inf")

    def due(self, t: float) -> None:
        """Make every fault happen that is due at `t` (s) and has not happened.

        Raises
        ------
        ConfigurationError
            Its value is none that it takes.
        """
        while self._waiting and self._waiting[-1].at <= t:
            entry = self._waiting.pop()
            try:
                self._targets[entry.device].inject(entry.fault, entry.size)
            except ValueError as error:
                raise ConfigurationError(f"simulation.faults: {error}") from error


class FaultyWorld:
    """A world in which scheduled faults happen at their time, within a sleep or between two."""

    def __init__(self, world: World, schedule: FaultSchedule) -> None:
        self._world = world
        self._schedule = schedule
        schedule.due(0.0)

    def advance(self, t: float) -> None:
        """Let time pass up to `t` (s), with a halt at each fault."""
        schedule = self._schedule
        while schedule.next_time <= t:
            now = schedule.next_time
            self._world.advance(now)
            schedule.due(now)
        self._world.advance(t)


def _check(entry: ScheduledFault, targets: Mapping[str, Faulty]) -> None:
    target = targets.get(entry.device)
    if target is None:
        raise ValueError(
            f"simulation: no device {entry.device!r} to fail; there are {', '.join(targets)}"
        )
    known = target.known_faults
    if entry.fault not in known:
        # Of a device with joints, or a plant with channels, one of theirs shows how to name them.
        common = [fault for fault in known if "." not in fault]
        own = next((fault for fault in known if "." in fault), None)
        alone = f", or for one part alone as in {own!r}" if own else ""
        meant = [fault for fault in known if fault.endswith(f".{entry.fault}")]
        meant = meant or difflib.get_close_matches(entry.fault, known, n=3)
        hint = f" (did you mean {' or '.join(meant[:4])}?)" if meant else ""
        raise ValueError(
            f"{entry.device}: no fault {entry.fault!r}{hint}; known are "
            f"{', '.join(common)}{alone}; "
            "`rig faults list RIG` says what its own names are called here"
        )
