"""Hours in which nothing breaks: a rig that is stopped in them was stopped for nothing.

Experiment and unit are drawn anew for every run: another seed, and a rig that differs from its
profile by drawn bounds, as one does some time after it was calibrated.
"""

import random
import re
import shlex
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final, NamedTuple

from rig.assembly import Backend, Rig
from rig.assembly.simulated import friction_drawn
from rig.experiment.ending import ending_of
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.faults.subject import Subject
from rig.faults.verdict import MISSED, OK
from rig.faults.workers import Tell, share_out
from rig.runtime.phases import Timings

HOUR: Final = 3600.0
BOUNDS: Final = {
    "setpoint_gain": 5e-3, "setpoint_offset": 1e3, "monitor_gain": 5e-3, "monitor_offset": 1e3,
    "encoder_scale": 1e-3, "encoder_offset": 0.1e-3, "wire_offset": 0.1e-3, "friction": 0.3,
    "stribeck": 0.3, "joint_zero": 2e-3, "joint_scale": 1e-3,
}  # fmt: skip
"""Widest bounds of `simulation.perturbation`, SI: more than a calibration leaves, and friction that
has changed since. The alarms of the joint do not hold for one that was never calibrated."""
GROWN: Final = 0.2
"""Share by which a unit's friction is more than its profile says, so that it may be stopped for it
under that name. `rig calibrate RIG friction` leaves 0.15 open."""
_FRICTION = re.compile("sticks and slips at|more friction than the profile says")


@dataclass(frozen=True, slots=True)
class QuietRun:
    """A drawn run in which nothing breaks.

    Parameters
    ----------
    rig, experiment : str
        What is run.
    options : tuple of str
        The unit that it is run on: seed and perturbation.
    configs : str
        The folder of the configurations, if it was named.
    on : Backend
        ``virtual``, or ``sim``: without frames, and several times as fast.
    """

    rig: str
    experiment: str
    options: tuple[str, ...]
    configs: str = ""
    on: Backend = Backend.VIRTUAL

    @property
    def command(self) -> str:
        """The command that runs it again."""
        words = ["rig", "run", self.experiment, "--rig", self.rig, "--on", self.on]
        words += [word for option in self.options for word in ("--set", option)]
        words += ["--configs", self.configs] if self.configs else []
        return shlex.join(words)


class QuietEnding(NamedTuple):
    """The end of a quiet run.

    Parameters
    ----------
    run : QuietRun
        Which.
    duration : float
        How long it took on the rig's clock, s.
    code : int or None
        Its exit code; None if its process died.
    message : str
        What stopped it.
    friction : float
        The share of the friction that the unit was drawn to have besides.
    """

    run: QuietRun
    duration: float
    code: int | None
    message: str
    friction: float = 0.0

    @property
    def is_right(self) -> bool:
        """Whether it was stopped for friction that has grown, and says so."""
        is_stopped = self.code not in (OK, MISSED)
        return is_stopped and self.friction > GROWN and _FRICTION.search(self.message) is not None

    @property
    def is_trip(self) -> bool:
        """Whether it was stopped although nothing was broken."""
        return self.code not in (OK, MISSED) and not self.is_right

    def as_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return self._asdict() | {
            "run": asdict(self.run), "trip": self.is_trip, "right": self.is_right,
            "again": self.run.command,
        }  # fmt: skip


def draw_quiet(
    subjects: Sequence[Subject],
    hours: float,
    seed: int,
    configs: Path | None,
    on: Backend = Backend.VIRTUAL,
) -> list[QuietRun]:
    """Draw runs that take so many hours of the rigs' clocks together, each rig its share."""
    chance = random.Random(f"{seed} quiet")
    lengths = {subject.rig: _lengths(subject, configs) for subject in subjects}
    spent = dict.fromkeys(lengths, 0.0)
    drawn = []
    while sum(spent.values()) < hours * HOUR:
        rig = min(spent, key=lambda name: spent[name])
        experiment = chance.choice(list(lengths[rig]))
        spent[rig] += lengths[rig][experiment]
        unit = (f"simulation.seed={chance.randrange(1_000_000)}", _perturbation(chance))
        place = "" if configs is None else str(configs)
        drawn.append(QuietRun(rig, experiment, unit, place, on))
    return drawn


def run_quietly(
    runs: Sequence[QuietRun],
    out: Path,
    workers: int,
    progress: Callable[[QuietEnding], None],
) -> list[QuietEnding]:
    """Run them, and return how each ended.

    Parameters
    ----------
    runs : sequence of QuietRun
        As drawn.
    out : Path
        Where the run folders go; those that were not stopped are removed.
    workers : int
        How many at once.
    progress : callable
        Told each ending as it comes.
    """
    endings: dict[int, QuietEnding] = {}

    def perform(task: tuple[int, QuietRun], tell: Tell) -> None:
        number, run = task
        tell((number, _run(run, out / f"quiet-{number}")))

    for number, ending in share_out(list(enumerate(runs)), perform, workers):
        endings[number] = ending
        progress(ending)
    for number, run in enumerate(runs):  # a worker that died has not been quiet
        if number not in endings:
            endings[number] = QuietEnding(run, 0.0, None, "its worker ended without a word")
            progress(endings[number])
    return [endings[number] for number in range(len(runs))]


class _Stopwatch(Watcher):
    rig: Rig | None = None

    def built(self, rig: Rig) -> None:
        """Take note of whose clock it is."""
        self.rig = rig


def _run(run: QuietRun, out: Path) -> QuietEnding:
    watch, friction = _Stopwatch(), 0.0
    try:
        configs = Path(run.configs) if run.configs else None
        plan = load_plan(run.experiment, run.options, rig=run.rig, configs=configs)
        friction = friction_drawn(plan.profile)
        result = run_experiment(plan, run.on, out, watcher=watch, report=False)
        code, message = result.exit_code, result.message
    except Exception as error:  # a bug of ours stops a rig as well
        ending = ending_of(error)
        code, message = ending.code, ending.message
    duration = 0.0 if watch.rig is None else watch.rig.clock.now()
    ended = QuietEnding(run, duration, code, message or "", friction)
    if not ended.is_trip:
        shutil.rmtree(out, ignore_errors=True)
    return ended


def _lengths(subject: Subject, configs: Path | None) -> Mapping[str, float]:
    """Return about how long each experiment of a rig takes, s."""
    around = Timings().energise + Timings().release
    found = {}
    for name in subject.experiments:
        plan = load_plan(name, rig=subject.rig, configs=configs)
        found[name] = around + plan.experiment.approach + plan.motion.duration
    return found


def _perturbation(chance: random.Random) -> str:
    bounds = ", ".join(f"{name}: {most * chance.random():.4g}" for name, most in BOUNDS.items())
    return f"simulation.perturbation={{{bounds}}}"
