"""When each fault of a case could first be seen."""

from collections.abc import Sequence
from math import inf

from rig.faults.case import Break
from rig.faults.kind import Must, Samples, Sizes, at_once
from rig.faults.subject import Subject

SHOWN = 0.5
"""s: so long what only motion shows has to show, before the rig is told to stop or in that stop, to
be wanted seen. An orderly stop may leave a pair where it stands, and its seals hold it there."""


class Felt:
    """The times from which the faults of a case are felt.

    What spoils the law is felt when the law is followed. What befalls setpoints is felt when they
    next say something else: at rest there is nothing to be late. All else is felt at once.

    Parameters
    ----------
    subject : Subject
        The rig.
    """

    def __init__(self, subject: Subject) -> None:
        self._subject = subject
        self._made: list[tuple[Break, float]] = []
        self._at: list[float | None] = []

    def __len__(self) -> int:
        """Return how many faults have happened."""
        return len(self._made)

    @property
    def made_at(self) -> tuple[float, ...]:
        """When each happened, s."""
        return tuple(at for _, at in self._made)

    @property
    def times(self) -> tuple[float | None, ...]:
        """When each could first be seen, s; None: it never could."""
        return tuple(self._at)

    def make(self, item: Break, now: float) -> None:
        """Take a fault that happens at `now` (s)."""
        self._made.append((item, now))
        self._at.append(None if item.row.spoils_law or item.row.in_setpoints else now)

    def spoil(self, now: float) -> bool:
        """Take a command that is spoilt; return whether the first fault is felt from now on, s."""
        before = self._at[:1]
        for k, (item, _) in enumerate(self._made):
            if self._at[k] is None and item.row.spoils_law:
                self._at[k] = now
        return before == [None] and self._at[0] is not None

    def change(self, k: int, now: float) -> None:
        """Take setpoints that have changed under fault `k`, at `now` (s).

        What is left of it must be enough to be seen.
        """
        item, made = self._made[k]
        left = Sizes(item.magnitude, made + item.lasts - now)
        if self._at[k] is None and item.row.must(left, self._subject) is Must.SAFE:
            self._at[k] = now

    def shown(
        self,
        columns: Sequence[str],
        times: Samples,
        rows: Samples,
        until: float,
        stops: float = inf,
    ) -> tuple[float | None, ...]:
        """Return `times` by what is true: what had nothing to act on was not felt.

        Nor was what has acted for less than the time in which it must be seen.

        Parameters
        ----------
        columns : sequence of str
            Of the plant's truth.
        times : ndarray, shape (n,)
            s, ascending.
        rows : ndarray, shape (n, len(columns))
            What was true then.
        until : float
            When the program's loop ended, s.
        stops : float
            When it was told to end, s.
        """
        found: list[float | None] = []
        for (item, _), at in zip(self._made, self._at, strict=True):
            axis = item.place(self._subject).axis
            opposite = self._subject.opposite(axis)
            by = tuple(one.format(axis=axis, opposite=opposite) for one in item.row.shown_by)
            telling = [k for k, column in enumerate(columns) if column.startswith(by)]
            if at is None or item.row.shows is at_once or not telling:
                found.append(at)
                continue
            windows: Sequence[tuple[float, float]] = [(at, until)]
            lasts = item.row.within
            if item.row.in_motion:
                windows = [(at, min(stops, until)), (max(at, stops), until)]
                lasts = SHOWN
            found.append(None)
            for begin, end in windows:
                kept = (times >= begin) & (times <= end)
                first = item.row.shows(item.sizes, times[kept], rows[kept][:, telling])
                if first is not None and first + lasts <= end:
                    found[-1] = first
                    break
        return tuple(found)
