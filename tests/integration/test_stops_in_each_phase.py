"""A run is asked to stop in each of its phases, by another process: it ends, whole and safe."""

import contextlib
import random
import signal
import subprocess
import sys
import threading
import urllib.request
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from watched import served_folder

from rig.assembly import Backend, build_rig
from rig.calibration.catalogue import pick
from rig.calibration.session import record
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.faults.stage import Program, Stage
from rig.run_folder import RunFolder
from rig.runtime.log import read_log
from rig.runtime.phases import Timings
from rig.runtime.states import RigState

CONFIGS = Path(__file__).parents[2] / "configs"
DRAWN = random.Random(1312)
EXPERIMENTS = {
    "cylinder": ("cylinder-sine", "reference.tones=[{frequency: 1 Hz, periods: 2}]"),
    "joint": ("joint-circle", "reference.tones=[{frequency: 0.5 Hz, laps: 1}]"),
    "arm": ("arm-elbow-turnback",),
    "legs-can": ("legs-squat",),
}
PNEUMATIC = ("cylinder", "joint")
"""Mechanisms whose pressure is lowered at the end; drives hold what they have."""
PHASES = ("connect", "energise", "approach", "run", "release")
VENTED = 20e3
"""Gauge pressure of a chamber that moves nothing any more, Pa."""
WATCHED = 1.5
"""For how long the plant is watched after the end of the program, s."""
STILL = 1e-3
"""What a joint may move in the last fifth of a second, rad: on a brake it creeps no further."""


@cache
def plan_of(rig):
    experiment, *options = EXPERIMENTS[rig]
    return load_plan(experiment, [*options, "metrics={}", "figures=[]"], rig=rig, configs=CONFIGS)


@cache
def connecting(rig):
    """Return how long it takes until the loop begins, s."""
    with build_rig(plan_of(rig).profile, Backend.VIRTUAL) as made:
        made.arm()
        return made.clock.now()


def span(rig, phase):
    """Return from when to when a phase lasts, s since the loop began; negative: before that."""
    timings, plan = Timings(), plan_of(rig)
    start = timings.energise + plan.experiment.approach
    end = start + plan.motion.duration
    lowered = timings.release if plan.profile.mechanism in PNEUMATIC else 0.0
    return {
        "connect": (-connecting(rig), 0.0),
        "energise": (0.0, timings.energise),
        "approach": (timings.energise, start),
        "run": (start, end),
        "release": (end, end + timings.brake + timings.settle + lowered),
    }[phase]


class Stopping(Watcher):
    """Has another process called at an instant, while the run's world stands still for it.

    `at` is in s since the loop began; negative: as long after the rig was opened. `ask` gets the
    run's folder, in a thread: a signal of its own interrupts who waits for it.
    """

    def __init__(self, at, ask):
        self._at, self._ask = at, ask
        self._thread = None

    def built(self, rig):
        self._stage = rig.clock.world = Stage(rig.clock, Program(lambda: None))
        self.columns = [column.name.removeprefix("truth.") for column in rig.truth_columns]
        self.joints = self._stage.world.plant.channel_names

    def started(self, path):
        self.folder = path
        if self._at < 0.0:
            self._stage.cue(-self._at, self._press)

    def moved(self, state, t):
        if state is RigState.RUNNING and self._at >= 0.0:
            self._stage.cue(self._stage.clock.now() + self._at, self._press)

    def _press(self):
        self._thread = threading.Thread(target=self._ask, args=(self.folder,))
        self._thread.start()
        self._thread.join()

    def truth(self):
        """Return the truth until well after the program's end: a row for each millisecond."""
        self._thread.join()
        self._stage.watch_on(WATCHED)
        return np.array(self._stage.truth.rows)


def by_command(folder, how):
    command = [sys.executable, "-m", "rig", "stop", folder.name, "--runs", str(folder.parent)]
    options = ["--at-once"] if how == "at once" else []
    subprocess.run([*command, "--wait", "0", *options], check=True, capture_output=True)


def by_page(folder, how):
    with served_folder(folder) as address:
        where = address.partition("/#")[0]
        form = f"how={how.replace(' ', '+')}".encode()
        request = urllib.request.Request(f"{where}/stop", form, {"Origin": where})
        with urllib.request.urlopen(request, timeout=30) as answer:
            assert "asked to stop" in answer.read().decode()


@pytest.fixture
def strays():
    """Signals that come when the run no longer listens: they would end its process unasked."""
    heard = []
    before = signal.signal(signal.SIGTERM, lambda number, _: heard.append(number))
    yield heard
    signal.signal(signal.SIGTERM, before)


def judge(watcher, message):
    """Hold the end of a stopped run to what is promised of it."""
    folder = RunFolder.open(watcher.folder)
    manifest = folder.manifest
    assert not folder.is_live()
    assert (manifest["exit_code"], folder.status.value) == (130, "aborted"), manifest["message"]
    assert manifest["ended"]
    assert message in manifest["message"]
    faults = [event for event in folder.events() if event["kind"] in ("fault", "unsafe")]
    assert [f for f in faults if f["data"].get("type") != "KeyboardInterrupt"] == []
    if folder.log_path.exists():
        assert read_log(folder.log_path).complete
    rows = watcher.truth()
    names = watcher.columns
    pressures = [k for k, name in enumerate(names) if name.startswith("pressure_")]
    joints = [k for k, name in enumerate(names) if name in watcher.joints]
    assert pressures or joints
    assert (rows[-1, pressures] <= VENTED).all()
    assert (np.ptp(rows[-200:, joints], axis=0) <= STILL).all()
    if "fell" in names:
        assert not rows[:, names.index("fell")].any()


def draw(count, rigs, phases):
    """Return rigs, phases, shares of their time, ways to ask, and how; every phase in turn."""
    return [
        (
            DRAWN.choice(rigs),
            phases[k % len(phases)],
            DRAWN.uniform(0.02, 0.98),
            DRAWN.choice([by_command, by_page]),
            DRAWN.choice(["orderly", "at once"]),
        )
        for k in range(count)
    ]


def stop_in(tmp_path, rig, phase, share, ask, how):
    start, end = span(rig, phase)
    if phase == "connect":  # counted from the rig's opening
        start, end = 0.0, start
    watcher = Stopping(start + share * (end - start), lambda folder: ask(folder, how))
    with contextlib.suppress(KeyboardInterrupt):  # a second signal while it closes what it opened
        run_experiment(plan_of(rig), Backend.VIRTUAL, tmp_path, watcher=watcher, report=False)
    said = {"orderly": "stopped by the operator", "at once": "stopped at once"}[how]
    judge(watcher, "interrupted" if phase == "connect" else said)


@pytest.mark.parametrize(("rig", "phase", "share", "ask", "how"), draw(5, ["cylinder"], PHASES))
def test_a_stop_is_heard_in_each_phase(tmp_path, strays, rig, phase, share, ask, how):
    stop_in(tmp_path, rig, phase, share, ask, how)
    assert strays == []


@pytest.mark.slow
@pytest.mark.sampled(10)
@pytest.mark.parametrize(
    ("rig", "phase", "share", "ask", "how"), draw(60, list(EXPERIMENTS), PHASES)
)
def test_a_stop_is_heard_on_each_rig(tmp_path, strays, rig, phase, share, ask, how):
    stop_in(tmp_path, rig, phase, share, ask, how)
    assert strays == []


def test_a_run_that_has_ended_hears_no_stop(tmp_path):
    watcher = Stopping(1e9, None)
    result = run_experiment(
        plan_of("cylinder"), Backend.VIRTUAL, tmp_path, watcher=watcher, report=False
    )
    assert result.exit_code == 0
    before = (result.path / "manifest.json").read_bytes()
    with pytest.raises(subprocess.CalledProcessError) as refused:
        by_command(result.path, "at once")
    assert refused.value.returncode == 1
    assert b"is not running: there is nothing to stop" in refused.value.stderr
    assert (result.path / "manifest.json").read_bytes() == before


@pytest.mark.slow
@pytest.mark.parametrize("procedure", ["regulators", "response"])
@pytest.mark.parametrize(("ask", "how"), [(by_command, "orderly"), (by_page, "at once")])
def test_a_calibration_is_stopped_as_a_run_is(tmp_path, strays, procedure, ask, how):
    profile = plan_of("cylinder").profile
    (chosen,) = pick(profile, (procedure,))
    duration = chosen.excite(profile, ()).motion.duration
    at = Timings().energise + DRAWN.uniform(0.0, duration)
    watcher = Stopping(at, lambda folder: ask(folder, how))
    record(chosen, profile, Backend.VIRTUAL, tmp_path, watcher=watcher)
    judge(watcher, "by the operator")
    assert strays == []
