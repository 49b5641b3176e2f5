"""A run with its progress line, and with a page on which it is watched, if that was asked for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rig.cli.progress import ProgressLine
from rig.experiment.pacing import BURST, RealTime
from rig.runtime.loop import Progress

if TYPE_CHECKING:
    from rig.experiment.plan import Plan
    from rig.hal.controller import AnyController
    from rig.runtime.phases import Events
    from rig.steering.mailbox import Mailbox
    from rig.steering.online_gains import OnlineGains


class WatchedRun(ProgressLine):
    """Shows the progress, serves the page, and keeps a simulation from running away.

    The page is served by a process of its own, which reads the run's folder.

    Parameters
    ----------
    plan : Plan
        What is run.
    on : str
        On what.
    needs_hold : bool
        Gains change only while somebody holds on to the page: on hardware.
    pace : float or None
        Times real time that it runs at most; None: as fast as it can.
    watch, steer : bool
        Whether there is a page, and whether gains may be changed on it.
    beside : Path, optional
        The folder of a run that the page lays under this one.
    """

    def __init__(
        self,
        plan: Plan,
        on: str,
        *,
        needs_hold: bool,
        pace: float | None = None,
        watch: bool = False,
        steer: bool = False,
        beside: Path | None = None,
    ) -> None:
        super().__init__(plan.experiment.name, on)
        self._watch, self._steer = watch, steer
        self._time = None if pace is None else RealTime(pace)
        if pace is not None:
            self.progress_every = BURST
        self._beside = beside
        self._law, self._period = plan.experiment.controller, plan.profile.loop.period
        self._needs_hold = needs_hold
        self._box: Mailbox | None = None
        self._gains: OnlineGains | None = None
        self._path: Path
        self._events: Events

    def started(self, path: Path) -> None:
        """Say where the run is recorded, and serve its page."""
        super().started(path)
        self._path = path
        if self._steer:
            from rig.steering.mailbox import Mailbox

            self._box = Mailbox(path, create=True)
        if self._watch:
            command = [sys.executable, "-m", "rig", "watch", str(path), "--until-left"]
            if self._beside is not None:
                command += ["--beside", str(self._beside)]
            # A session of its own: Ctrl-C in this terminal is for the run. The page shows its end.
            self._server = subprocess.Popen(
                [*command, *(["--steer"] if self._steer else [])],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )

    def recording(self, events: Events) -> None:
        """Remember what changes of gains are written to."""
        self._events = events

    def employed(self, controller: AnyController) -> AnyController:
        """Return the controller, with the mailbox in front of it if gains may be changed."""
        from controllers.base import Law

        if self._box is None:  # also in a rehearsal, which is before there is a folder
            return controller
        if not isinstance(controller, Law) or not controller.online:
            self.said("this law has no gains that may be changed while it runs")
            return controller
        from rig.steering.online_gains import OnlineGains

        self._gains = OnlineGains(controller, self._box, needs_hold=self._needs_hold)
        return self._gains

    def keep_gains(self) -> None:
        """Leave what was changed as a difference to the profile, in the run's folder."""
        if self._gains is None or not (changed := self._gains.changed):
            return
        import yaml

        from rig.tuning.gains import nested

        text = yaml.safe_dump({"controllers": {self._law: nested(changed)}})
        (self._path / "gains.yaml").write_text(text, encoding="utf-8")
        self.said(f"gains were changed: {self._path / 'gains.yaml'}")

    def _tell_of_gains(self, progress: Progress) -> None:
        gains = self._gains
        if gains is None:
            return
        import getpass

        for said in gains.said:
            t = progress.elapsed - (gains.cycle - said.cycle) * self._period
            data = {"who": getpass.getuser(), **said.data}
            self._events(t, "tuning", said.message, data)
        gains.said.clear()

    def progressed(self, progress: Progress) -> None:
        """Redraw the line, and wait for real time where simulated time is ahead of it."""
        super().progressed(progress)
        self._tell_of_gains(progress)
        if self._time is not None:
            self._time.wait(progress.elapsed)
