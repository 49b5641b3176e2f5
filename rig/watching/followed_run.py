"""A run as its page sees it: what its folder says, and its log as far as it goes."""

from collections.abc import Callable, Iterator
from math import isfinite
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.hal import ConfigurationError, RigError
from rig.hal.columns import Column
from rig.hal.files import open_regular
from rig.run_facts import EVENTS, Event
from rig.run_folder import RunFolder
from rig.runtime.log_tail import LogTail
from rig.typed_json import checked, parse
from rig.watching.extremes import Extremes, reduce_by, stretch_for

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Times = NDArray[np.float64]
    Values = NDArray[np.float32]

_STRETCHES = 400
"""From so many stretches on, the extremes that are kept are fine enough for a screen."""
_ROWS_AT_ONCE = 4096
_LOOKS_BACK = 1.0
"""Of the statistics of cycles, s of the rig's time."""
_MOST_EVENTS = 2000
_EVENTS_AT_ONCE = 1 << 20
"""Bytes of them that are read at once."""
_LONGEST_SENTENCE = 2000
RUN = 1.0
"""What the column ``phase`` says while the reference is followed."""
SIMULATED = ("sim", "virtual", "vcan")
"""Backends that move nothing; whatever else a manifest says is taken for hardware."""


class CycleFacts(NamedTuple):
    """The last second of cycles, in numbers.

    Parameters
    ----------
    t, reference_time : float
        Of the last one, s.
    phase : float
        0 approach, 1 run, 2 stop; negative before the first cycle.
    rate : float
        Cycles in a second of the rig's time.
    missed : int
        Ticks that were skipped since the start.
    late : float
        99th percentile of the lateness, s.
    slack : float
        Least time that was left of a period, s.
    """

    t: float = 0.0
    reference_time: float = 0.0
    phase: float = -1.0
    rate: float = 0.0
    missed: int = 0
    late: float = 0.0
    slack: float = 0.0


class FollowedRun:
    """One run folder, read further with each `advance`; nothing of it is read twice.

    Memory does not grow with the run: rows stay in the file, and `Extremes` are of fixed size.

    Parameters
    ----------
    path : Path
        The folder, of a run that goes on or has ended.

    Attributes
    ----------
    folder : RunFolder
        As it was found last.
    columns : tuple of Column
        Of the log; empty until it has begun.
    events : list of Event
        The last `_MOST_EVENTS` of them.
    first_event : int
        Number of the first one that is kept.
    grew_at : float
        When the last row came, on the monotonic clock, s.
    trouble : str or None
        Why the log cannot be read any further.

    Raises
    ------
    ConfigurationError
        It is not a run folder.
    """

    def __init__(self, path: str | Path) -> None:
        self.folder = RunFolder.open(path)
        self.columns: tuple[Column, ...] = ()
        self.events: list[Event] = []
        self.first_event = 0
        self.grew_at = monotonic()
        self.trouble: str | None = None
        self._tail = LogTail(self.folder.log_path)
        self._extremes: Extremes | None = None
        self._events_read = 0
        self._began: float | None = None

    @property
    def count(self) -> int:
        """Rows that were read."""
        return self._tail.count

    @property
    def is_live(self) -> bool:
        """Whether a living process works on the run."""
        return self.folder.is_live()

    @property
    def is_simulated(self) -> bool:
        """Whether the run moves nothing but numbers."""
        return self.folder.manifest.get("backend") in SIMULATED

    def advance(self) -> int:
        """Read what was added to the log, about a megabyte at most; return how many rows."""
        if self.trouble is not None:
            return 0
        try:
            rows = self._tail.read()
        except (RigError, OSError) as error:
            self.trouble = str(error)
            return 0
        if not self.columns and self._tail.columns:
            self.columns = self._tail.columns
            self._extremes = Extremes(len(self.columns))
        if len(rows) and self._extremes is not None:
            self._extremes.add(rows["t"], rows["row"])
            self.grew_at = monotonic()
        return len(rows)

    def look_again(self) -> None:
        """Read the manifest again, and the events that were added."""
        try:
            self.folder = RunFolder.open(self.folder.path)
        except (RigError, OSError) as error:  # it was moved, deleted, damaged: what is here stays
            self.trouble = self.trouble or str(error)
            return
        try:
            with open_regular(self.folder.path / EVENTS) as stream:
                stream.seek(self._events_read)
                content = stream.read(_EVENTS_AT_ONCE)
        except (OSError, ConfigurationError):
            return
        whole = content[: content.rfind(b"\n") + 1]
        if not whole and len(content) == _EVENTS_AT_ONCE:
            whole = content  # no event is as long as that: what it is, nobody can show
        self._events_read += len(whole)
        for line in whole.splitlines():
            event = _event_of(line)
            if event is not None:
                self.events.append(event)
        if len(self.events) > _MOST_EVENTS:
            surplus = len(self.events) - _MOST_EVENTS
            del self.events[:surplus]
            self.first_event += surplus

    def row_at(self, t: float) -> int:
        """Return the number of the first row that is not before a time, s."""
        return self._first_row(lambda row: bool(row["t"] >= t))

    def motion_began(self) -> float | None:
        """Return the time at which the reference began, s; None: it has not, or nothing says so."""
        if self._began is None and self.count:
            names = [column.name for column in self.columns]
            if "phase" not in names:
                return None
            phase = names.index("phase")
            first = self._first_row(lambda row: bool(row["row"][phase] >= RUN))
            if first < self.count:
                row = self._tail.rows(first, first + 1)[0]
                if row["row"][phase] > RUN:
                    return None  # it was stopped on its way there
                known = "reference.time" in names
                since = row["row"][names.index("reference.time")] if known else 0.0
                self._began = float(row["t"] - since)
        return self._began

    def _first_row(self, is_there: "Callable[[np.void], bool]") -> int:
        """Return the number of the first row for which it is so, as it is for all after it."""
        low, high = 0, self.count
        while low < high:
            middle = (low + high) // 2
            if is_there(self._tail.rows(middle, middle + 1)[0]):
                high = middle
            else:
                low = middle + 1
        return low

    def window(
        self, first: int, last: int, columns: "NDArray[np.intp]", most: int
    ) -> "tuple[Times, Values]":
        """Return rows, or the extremes of stretches of them if they are more than `most`.

        Parameters
        ----------
        first, last : int
            From the first one up to but without the last one.
        columns : ndarray of int
            Which columns, (c,).
        most : int
            Rows that are returned, about.

        Returns
        -------
        t : ndarray, shape (m,)
            s.
        values : ndarray, shape (m, c)
            Rows as they were recorded, or by turns the least and the greatest of stretches.
        """
        return joined(list(self.pieces(first, last, columns, most)), len(columns))

    def pieces(
        self, first: int, last: int, columns: "NDArray[np.intp]", most: int
    ) -> "Iterator[tuple[Times, Values]]":
        """Yield a `window` piece by piece, each in some milliseconds: others want their turn."""
        first, last = max(first, 0), min(last, self.count)
        if self._extremes is None or last <= first:
            return
        if last - first > _STRETCHES * self._extremes.stretch and last - first > most:
            yield self._extremes.between(first, last, columns, most)
            return
        # Whole stretches each: a window may be larger than what is to be kept in memory.
        stretch = stretch_for(last - first, most) if last - first > most else 1
        at_once = max(_ROWS_AT_ONCE // stretch, 1) * stretch
        for start in range(first, last, at_once):
            rows = self._tail.rows(start, min(start + at_once, last))
            t, values = rows["t"], rows["row"][:, columns].astype(np.float32)
            yield reduce_by(t, values, stretch) if stretch > 1 else (t, values)

    def samples(self, numbers: "NDArray[np.intp]") -> "tuple[Times, NDArray[np.float64]]":
        """Return single rows by their numbers: their times, s, and all of their values."""
        picked = [self._tail.rows(int(k), int(k) + 1) for k in numbers]
        if not picked:
            return np.empty(0), np.empty((0, len(self.columns)))
        rows = np.concatenate(picked)
        return rows["t"], rows["row"]

    def facts(self) -> CycleFacts:
        """Return what the last second of cycles was like."""
        last = self.count
        if not last:
            return CycleFacts()
        # Two rows tell the rate: a log may have any.
        ends = self._tail.rows(max(last - 2, 0), last)
        period = max(float(ends["t"][-1] - ends["t"][0]), 1e-5)
        rows = self._tail.rows(max(last - min(int(_LOOKS_BACK / period), 5000) - 1, 0), last)
        values = dict(zip([column.name for column in self.columns], rows["row"].T, strict=True))
        nothing = np.zeros(len(rows))
        span = float(rows["t"][-1] - rows["t"][0])
        return CycleFacts(
            t=float(rows["t"][-1]),
            reference_time=float(values.get("reference.time", rows["t"])[-1]),
            phase=float(values.get("phase", nothing)[-1]),
            rate=(len(rows) - 1) / span if span > 0.0 else 0.0,
            missed=max(int(rows["cycle"][-1]) + 1 - last, 0),
            late=float(np.percentile(values.get("timing.lateness", nothing), 99)),
            slack=float(np.min(values.get("timing.slack", nothing))),
        )

    def close(self) -> None:
        """Let go of the files."""
        self._tail.close()


def joined(pieces: "list[tuple[Times, Values]]", columns: int) -> "tuple[Times, Values]":
    """Return the pieces of a window as one."""
    if not pieces:
        return np.empty(0), np.empty((0, columns), np.float32)
    return np.concatenate([t for t, _ in pieces]), np.concatenate([values for _, values in pieces])


def _event_of(line: bytes) -> Event | None:
    """Return an event in plain types of bounded length; None if it is none."""
    try:
        told = checked(parse(line.decode(errors="replace")), Event, EVENTS)
    except (ValueError, RecursionError, ConfigurationError):
        return None
    data = told.get("data", {}) if len(line) < _LONGEST_SENTENCE else {}
    data = {key: value for key, value in data.items() if _is_plain(value)}
    return {
        "t": told.get("t"),
        "kind": told.get("kind", "")[:80],
        "message": told.get("message", "")[:_LONGEST_SENTENCE],
        "data": data,
    }


def _is_plain(value: object) -> bool:
    """Return whether it is text or a number, and not one that JSON lacks."""
    return isinstance(value, str | int) or (isinstance(value, float) and isfinite(value))
