"""Whether the code at hand commands what a run's log says, bit for bit."""

import struct
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from rig.hal import RigError
from rig.replaying.recorded import Logged, RecordedRun
from rig.replaying.retrace import Retrace

if TYPE_CHECKING:
    from rig.replaying.frames import FramesRig

_bits = struct.Struct("<d").pack

Agree: TypeAlias = Callable[[float, float], bool]


class Difference(NamedTuple):
    """The first number of a log that the code at hand does not arrive at.

    Parameters
    ----------
    row : int
        Place of the cycle in the log.
    cycle : int
        Its number.
    t : float
        s.
    column, unit : str
        Where the numbers differ.
    logged, now : float
        What the log says and what the code at hand makes of the same readings.
    others : tuple of str
        The other columns of the same cycle that differ.
    """

    row: int
    cycle: int
    t: float
    column: str
    unit: str
    logged: float
    now: float
    others: tuple[str, ...] = ()

    def __str__(self) -> str:
        more = f", and {len(self.others)} more columns" if self.others else ""
        return (
            f"cycle {self.cycle} ({self.t:.4f} s), {self.column}: the log says "
            f"{self.logged!r} {self.unit}, the code at hand {self.now!r} {self.unit} "
            f"(difference {self.now - self.logged:.3g}){more}"
        )


class Verification(NamedTuple):
    """The end of a replay.

    Parameters
    ----------
    cycles : int
        That were compared.
    unknown : int
        That could not be: what followed a fault whose own cycle has no row.
    difference : Difference or None
        The first.
    stopped : str or None
        Why the code at hand would not have gone on where the log does.
    """

    cycles: int
    unknown: int
    difference: Difference | None
    stopped: str | None

    @property
    def same(self) -> bool:
        """Whether every number is the log's."""
        return self.difference is None and self.stopped is None


def same_bits(one: float, other: float) -> bool:
    """Return whether two numbers are the same bits: a NaN is like itself, 0 is unlike -0."""
    return _bits(one) == _bits(other)


def verify(
    run: RecordedRun, frames: "FramesRig | None" = None, agree: Agree = same_bits
) -> Verification:
    """Feed a log's readings to the code at hand, and compare every number of every cycle.

    Parameters
    ----------
    run : RecordedRun
        What was recorded.
    frames : FramesRig, optional
        Has the drivers read anew what the buses carried, up to the cycle that saw a fault.
    agree : callable
        Whether two numbers are the same: bit for bit, unless they were made on another processor
        or with other libraries.
    """
    trace = Retrace(run.plan, frames=frames)
    columns = [(column.name, column.unit) for column in trace.columns]
    logged_names = {column.name for column in run.log.columns}
    lacking = [name for name, _ in columns if name not in logged_names]
    if lacking:
        return Verification(0, 0, None, f"the log has no column {', '.join(lacking)}")
    done = 0
    known = False
    for row, logged in enumerate(run.cycles()):
        fault = logged.values["fault"]
        # The cycle that saw the fault could not be recorded; or what followed took other calls.
        if fault == 2.0 and (not known or frames is not None):
            return Verification(done, len(run.log.cycle) - done, None, None)
        known = known or fault == 1.0
        try:
            values = trace.step(logged)
        except RigError as error:
            return Verification(done, 0, None, f"cycle {logged.cycle} ({logged.t:.4f} s): {error}")
        difference = _compare(row, logged, columns, values, agree)
        if difference is not None:
            return Verification(done, 0, difference, None)
        done += 1
    return Verification(done, 0, None, None)


def _compare(
    row: int,
    logged: Logged,
    columns: Sequence[tuple[str, str]],
    values: Iterable[float],
    agree: Agree = same_bits,
) -> Difference | None:
    differing = [
        (name, unit, value)
        for (name, unit), value in zip(columns, values, strict=True)
        if not agree(logged.values[name], value)
    ]
    if not differing:
        return None
    # A command first: the rest of a row may follow from it, and it is what moves the rig.
    name, unit, value = min(differing, key=lambda entry: not entry[0].startswith("command."))
    others = tuple(other for other, _, _ in differing if other != name)
    return Difference(row, logged.cycle, logged.t, name, unit, logged.values[name], value, others)
