"""Who watches a run: told of everything that happens, while it happens."""

from pathlib import Path

from rig.assembly import Rig
from rig.hal.controller import AnyController
from rig.runtime.loop import Progress
from rig.runtime.phases import Events
from rig.runtime.states import RigState


class Watcher:
    """Hears what happens during a run; every method may be overridden."""

    progress_every: float = 0.1
    """Seconds of rig time between two calls of `progressed`."""

    def built(self, rig: Rig) -> None:
        """Take note of the rig before anything of it is opened."""

    def rehearsing(self, rig: Rig) -> None:
        """Take note of the simulated rig on which the run is rehearsed."""

    def moved(self, state: RigState, t: float | None) -> None:
        """Take note that the rig is in another state now.

        Parameters
        ----------
        state : RigState
            The new one.
        t : float or None
            When the loop began the cycle that led to it, s; None before there is a loop.
        """

    def employed(self, controller: AnyController) -> AnyController:
        """Return the controller that the loop is to run: this one."""
        return controller

    def started(self, path: Path) -> None:
        """Take note that the run folder exists."""

    def recording(self, events: Events) -> None:
        """Take note of what writes into the run's events."""

    def said(self, sentence: str) -> None:
        """Pass one sentence to the operator."""

    def working(self, what: str) -> None:
        """Take note of what is done now that the rig is safe, and takes its time."""

    def progressed(self, progress: Progress) -> None:
        """Take note that some cycles went by."""
