"""How a run of the corpus is made: an experiment, shortened, with what happens to it on the way."""

import signal
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.faults.stage import Program, Stage
from rig.runtime.states import RigState


class Recording(NamedTuple):
    """A run that is kept.

    `events` are (s since the loop began, what happens, arguments): ``stop``, ``pause`` (s), or
    ``break`` (device, fault, value). `status` is how it has to end.
    """

    name: str
    reason: str
    experiment: str
    on: str = "virtual"
    options: tuple[str, ...] = ()
    events: tuple[tuple[object, ...], ...] = ()
    status: str = "aborted"
    frames: bool = False


class _Disturber(Watcher):
    """Has the events of a recording happen."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._program = Program(lambda: None)
        self._stage: Stage

    def built(self, rig):
        self._stage = rig.clock.world = _BlindStage(rig.clock, self._program)

    def moved(self, state, t):
        if state is RigState.RUNNING:
            start = self._stage.clock.now()
            for at, what, *arguments in self._recording.events:
                self._stage.cue(start + at, self._act(what, arguments))

    def _act(self, what: str, arguments: list[object]) -> Callable[[], None]:
        if what == "stop":
            return partial(signal.raise_signal, signal.SIGINT)
        if what == "pause":
            return partial(self._stage.clock.pause, *arguments)
        return partial(self._stage.world.inject, *arguments)


class _BlindStage(Stage):
    """A stage that needs no truth to look at: not every backend's world has a plant to ask."""

    def advance(self, t):
        while self._cues and self._cues[0].at <= t:
            cue = self._cues.pop(0)
            self.world.advance(cue.at)
            cue.act()
        self.world.advance(t)


def record(recording, out):
    """Run it; return the run folder."""
    plan = load_plan(recording.experiment, [*recording.options, "metrics={}", "figures=[]"])
    result = run_experiment(
        plan, Backend(recording.on), out, report=False, watcher=_Disturber(recording),
        frames="log" if recording.frames else None,
    )  # fmt: skip
    assert result.status.value == recording.status, (
        f"{recording.name} ended {result.status}, and not {recording.status}: {result.message}"
    )
    return result.path
