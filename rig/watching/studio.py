"""What all pages share: one reading of the log, one picture, one state of the run."""

import asyncio
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np

from rig.watching.cameras import Cameras
from rig.watching.followed_run import RUN, FollowedRun
from rig.watching.messages import FRAMES, Request, pack
from rig.watching.picture import Picture, Plain

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.watching.steering import Steering

TICK = 0.1
"""Between two readings of the log, s."""
_LOOK_EVERY = 5
"""Of so many ticks one looks at manifest and events."""
_FRAME_RATE = 30.0
"""Of the scene, 1/s of the rig's time."""
_LOOKS = 2000
"""Rows of a run that has ended in which its margins are looked at."""
_MOST_FRAMES = 6
"""New ones in one tick: a simulation may be faster than any eye."""


class Studio:
    """Reads on, ten times a second, for however many pages.

    Parameters
    ----------
    run : FollowedRun
        What is watched.
    steering : Steering, optional
        The way to the run's gains.
    beside : FollowedRun, optional
        Another run, to be laid under it.

    Attributes
    ----------
    picture : Picture or None
        The scene, once the log has begun.
    new_frames : tuple of bytes
        The scene in the rows of the last tick, packed.
    cameras : Cameras
        Of the run.
    new_pictures : tuple of bytes
        What they have seen since the last tick, packed.
    generation : int
        Grows when there is something else to be described.
    viewers : int
        Pages that look on.
    """

    def __init__(
        self,
        run: FollowedRun,
        steering: "Steering | None" = None,
        beside: FollowedRun | None = None,
    ) -> None:
        self.run = run
        self.picture: Picture | None = None
        self.new_frames: tuple[bytes, ...] = ()
        self.cameras = Cameras(run.folder.path)
        self.new_pictures: tuple[bytes, ...] = ()
        self.generation = 1
        self.viewers = 0
        self.steering = steering
        self.beside = beside
        self._live = run.is_live
        self._ticked = asyncio.Event()
        self._row = np.empty(0)
        self._status: Plain = {}
        self._framed_at = -np.inf
        self._margins: list[tuple[int, float]] = []
        self._worst_of = -1

    async def work(self, is_over: Callable[[], bool]) -> None:
        """Read on until `is_over` says so."""
        due, number = monotonic(), 0
        while not is_over():
            before = self.run.count
            while self.run.advance():
                await asyncio.sleep(0.0)  # a long log is read by pieces: others get their turn
                if self.run.count - before > 50_000 and self._live:
                    break
            if self.beside is not None:
                self.beside.advance()
            if self.picture is None and self.run.columns:
                self.picture = Picture(self.run.folder.path, self.run.columns)
                self.generation += 1
            if number % _LOOK_EVERY == 0:
                self.run.look_again()
                self._live = self.run.is_live
                self._status = {}
                if self._live and self.cameras.find():
                    self.generation += 1
            self.new_pictures = self.cameras.look() if self.viewers and self._live else ()
            self._draw(before)
            self._tick()
            number += 1
            due = max(due + TICK, monotonic())
            await asyncio.sleep(due - monotonic())

    async def next_tick(self) -> None:
        """Wait until the log was read on."""
        await self._ticked.wait()

    def described(self) -> Plain:
        """Return what a page has to know once."""
        manifest = self.run.folder.manifest
        steering = self.steering
        return {
            "type": "hello",
            "run": self.run.folder.path.name,
            "experiment": str(manifest.get("experiment")),
            "rig": str(manifest.get("rig")),
            "law": str(manifest.get("law")),
            "backend": str(manifest.get("backend")),
            "seed": manifest.get("seed"),
            "simulated": self.run.is_simulated,
            "columns": [list(column) for column in self.run.columns],
            "scene": {} if self.picture is None else self.picture.described(),
            "beside": None if self.beside is None else self.beside.folder.path.name,
            "cameras": list(self.cameras.names),
            "gains": [] if steering is None else steering.described(),
        }

    @property
    def shift(self) -> float:
        """How much later the motion of the run began than that of the run beside it, s."""
        began = (None if one is None else one.motion_began() for one in (self.run, self.beside))
        later, sooner = began
        return 0.0 if later is None or sooner is None else later - sooner

    def status(self) -> Plain:
        """Return how the run stands; computed once for all who ask within a tick."""
        if not self._status:
            run, manifest = self.run, self.run.folder.manifest
            facts = run.facts()
            if not self._live and self._worst_of != run.count:
                self._worst_of, self._margins = run.count, self._least_margins()
            elif self._live and facts.phase == RUN:
                self._margins = self._margins_in(np.array([run.count - 1]))
            self._status = {
                "type": "status",
                "live": self._live,
                "state": str(manifest.get("status")),
                "message": manifest.get("message"),
                "count": run.count,
                "trouble": run.trouble,
                "margins": [[k, round(share, 4)] for k, share in self._margins],
                **{name: _finite(value) for name, value in facts._asdict().items()},
            }
        return self._status | {"age": monotonic() - self.run.grew_at}

    def _margins_in(self, rows: "NDArray[np.intp]") -> list[tuple[int, float]]:
        """Return the columns that were nearest to their limits in some rows."""
        if self.picture is None or not len(rows):
            return []
        return self.picture.margins(self.run.samples(rows)[1])

    def _least_margins(self) -> list[tuple[int, float]]:
        """Return those of a run that has ended, while it followed its reference."""
        phase = [k for k, column in enumerate(self.run.columns) if column.name == "phase"]
        if not (phase and self.run.count):
            return []
        rows = np.linspace(0, self.run.count - 1, min(self.run.count, _LOOKS)).astype(np.intp)
        values = self.run.samples(rows)[1]
        return self._margins_in(rows[values[:, phase[0]] == RUN])

    def steer(self, request: Request) -> str | None:
        """Hand a change of a gain on; return what is to be said of it."""
        if self.steering is None:
            return "this run was not started with --steer"
        return self.steering.answer(request)

    def _tick(self) -> None:
        if self.run.count and self._live:
            self._status = {}
        self._ticked.set()
        self._ticked = asyncio.Event()

    def _draw(self, before: int) -> None:
        """Work the scene out for rows that have just come, if the run goes on and is looked at."""
        self.new_frames = ()
        picture, count = self.picture, self.run.count
        if picture is None or not (self.viewers and self._live and count > before):
            return
        if not picture.is_drawn:
            return
        first, last = self.run.samples(np.array([before, count - 1]))[0]
        wanted = int(np.clip((last - first) * _FRAME_RATE, 1, _MOST_FRAMES))
        numbers = np.unique(np.linspace(before, count - 1, wanted + 1).astype(np.intp)[1:])
        t, values = self.run.samples(numbers)
        fresh = t > self._framed_at + 0.5 / _FRAME_RATE
        if fresh.any():
            self._framed_at = float(t[-1])
            self.new_frames = (pack(FRAMES, 0, t[fresh], picture.frames(values[fresh])),)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
