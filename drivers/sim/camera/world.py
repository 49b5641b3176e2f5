"""A world that cameras watch: it halts whenever one of them exposes."""

from collections.abc import Sequence
from typing import Protocol

from drivers.sim.clock import World


class Watcher(Protocol):
    """Something that looks at a plant at times of its own, like an `EmulatedCamera`."""

    @property
    def due(self) -> float:
        """When it looks next, s."""
        ...

    def tick(self, now: float) -> None:
        """Take the time, and look if it is due; the world is at `now`, s."""
        ...


class WatchedWorld:
    """Brings a world to each instant at which a camera looks at it.

    Parameters
    ----------
    world : World
        What moves: a plant, or a rig of emulated nodes with its plant.
    watchers : sequence of Watcher
        Those who look.
    """

    def __init__(self, world: World, watchers: Sequence[Watcher]) -> None:
        self.world = world
        self._watchers = tuple(watchers)

    def advance(self, t: float) -> None:
        """Let time pass up to `t`, s."""
        while (due := min([watcher.due for watcher in self._watchers], default=t)) < t:
            self._advance(due)
        self._advance(t)

    def _advance(self, t: float) -> None:
        self.world.advance(t)
        for watcher in self._watchers:
            watcher.tick(t)
