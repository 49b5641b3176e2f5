"""How far gains are judged on every plant: the last part of `rig tune`, of several minutes."""

from __future__ import annotations

from typing import Self

from rig.sweeping.progress import SweepProgress


class JudgeProgress(SweepProgress):
    """Counts plants on which the gains of before and those of now were run.

    Parameters
    ----------
    total : int
        Plants, of both.
    """

    def __enter__(self) -> Self:
        self.say("on every plant of the ensemble, before and now …")
        return self

    def __exit__(self, *exception: object) -> None:
        self.clear()

    def tell(self, count: int) -> None:
        """Count plants, and show how far it is if it is time to."""
        self.done += count
        self.show(0)

    def text(self, running: int) -> str:
        """Return how far it is."""
        left = f", {self.time_left()}" if self.done < self.total else ""
        return f"{self.done}/{self.total} plants{left}"
