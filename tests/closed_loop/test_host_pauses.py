"""The host pauses the program, asleep or at work: it says so, and blames no device.

Drawn: how long, from 10 to 500 ms, and when. The devices go on meanwhile: they miss their master,
and do what they were told to do then.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend
from rig.experiment import run as run_module
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
RIGS = {
    "cylinder": ("cylinder-sine", "reference.tones=[{frequency: 1 Hz, periods: 2}]"),
    "joint": ("joint-circle", "reference.tones=[{frequency: 1 Hz, laps: 1}]"),
    "arm": ("arm-elbow-circle", "reference.rate=0.5 rad/s"),
    "arm-odrive": ("arm-elbow-circle", "reference.rate=0.5 rad/s"),
    "legs": ("legs-squat", "reference.repeats=1"),
    "legs-can": ("legs-squat", "reference.repeats=1"),
}
GENERATOR = np.random.default_rng(909)
MOST = 5
"""Ticks that may be missed in a row, in every profile."""
PLACES = [(rig, where) for rig in RIGS for where in ("asleep", "at work")]
LONG = [
    pytest.param(
        *place, float(np.exp(GENERATOR.uniform(*np.log((0.01, 0.5))))), GENERATOR.uniform(0.1, 2.9),
        id="-".join((*place, str(trial))), marks=[pytest.mark.slow] if trial else [],
    )
    for trial in range(8)
    for place in PLACES
]  # fmt: skip
SHORT = {
    place: (ticks, GENERATOR.uniform(0.1, 2.9))
    for place, ticks in zip(PLACES, GENERATOR.uniform(1.0, MOST, len(PLACES)), strict=True)
}
"""How long, in ticks, and when: one run of each rig meets its pause asleep and that at work."""


@cache
def plan_of(rig):
    """Return a plan, made once."""
    experiment, *options = RIGS[rig]
    more = ["approach=1 s", "metrics={}"]
    return load_plan(experiment, [*options, *more], rig=rig, configs=CONFIGS)


class Host:
    """Pauses a loop once, when its time has come: while it sleeps, or in the midst of its work."""

    def __init__(self, pause, after, where):
        self.pause, self.after, self.where = pause, after, where
        self.paused_at = None  # when the cycle began, s since the first

    def take(self, loop):
        """Pause this loop."""
        clock, limit = loop.clock, loop.mechanism.limit
        start, sleep_until = clock.now(), clock.sleep_until

        def pause():
            now = clock.now()
            if loop.t is not None and self.paused_at is None and now - start >= self.after:
                self.paused_at = loop.t
                sleep_until(now + self.pause)

        def oversleep(t):
            sleep_until(t)
            pause()

        def dawdle(command):
            pause()
            return limit(command)

        if self.where == "asleep":
            clock.sleep_until = oversleep
        else:
            loop.mechanism.limit = dawdle
        return loop


def run_paused(monkeypatch, out, rig, *hosts):
    make_loop = run_module._make_loop

    def paused(*rest):
        loop = make_loop(*rest)
        for host in hosts:
            host.take(loop)
        return loop

    monkeypatch.setattr(run_module, "_make_loop", paused)
    result = run_experiment(plan_of(rig), Backend.VIRTUAL, out, report=False)
    assert all(host.paused_at is not None for host in hosts)
    return result


@pytest.fixture(scope="module")
def run_of(tmp_path_factory):
    """Return what runs a rig through both short pauses, once, and returns both and the result."""

    @cache
    def run(rig):
        period = plan_of(rig).profile.loop.period
        hosts = {}
        for where in ("asleep", "at work"):
            ticks, after = SHORT[rig, where]
            hosts[where] = Host(ticks * period, after, where)
        with pytest.MonkeyPatch.context() as patch:
            result = run_paused(patch, tmp_path_factory.mktemp(rig), rig, *hosts.values())
        return hosts, result

    return run


@pytest.mark.parametrize(("rig", "where", "pause", "after"), LONG)
def test_a_pause_of_the_host_is_named_as_one(monkeypatch, tmp_path, rig, where, pause, after):
    host = Host(pause, after, where)
    result = run_paused(monkeypatch, tmp_path, rig, host)
    period = plan_of(rig).profile.loop.period
    events = RunFolder.open(result.path).events()
    (overrun,) = [event for event in events if event["kind"] == "overrun"]
    if result.exit_code == 0:  # it took it
        assert pause <= (MOST + 1) * period
        return
    assert (result.exit_code, pause > MOST * period) == (4, True)
    assert result.message.startswith("the program was paused for ")
    told = float(result.message.split()[5])
    assert 1e3 * pause - 0.1 < told < 1e3 * (pause + period) + 0.1
    assert ("in its own work" in result.message) == (where == "at work")
    (fault,) = [event for event in events if event["kind"] == "fault"]
    assert events.index(overrun) < events.index(fault)
    log = read_log(result.path / "log.mcap")
    lateness = log.column("timing.lateness")
    if where == "asleep":  # the cycle that woke up late is there, and sent nothing
        (late,) = np.flatnonzero(lateness > MOST * period)
        assert log.t[late] == pytest.approx(host.paused_at + period + pause)
    else:
        assert host.paused_at in log.t


@pytest.mark.parametrize(("rig", "where"), SHORT, ids=map("-".join, SHORT))
def test_a_short_pause_is_ridden_out(run_of, rig, where):
    hosts, result = run_of(rig)
    assert (result.exit_code, result.message) == (0, None)
    events = RunFolder.open(result.path).events()
    assert "fault" not in [event["kind"] for event in events]
    overruns = [event["t"] for event in events if event["kind"] == "overrun"]
    assert len(overruns) == len(hosts)
    host, period = hosts[where], plan_of(rig).profile.loop.period
    (_,) = [t for t in overruns if 0.0 <= t - host.paused_at <= host.pause + 1.001 * period]
