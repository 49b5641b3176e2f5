"""Late cycles and stops in mid-walk: the motion is held or ended, and no distance is lost."""

import numpy as np
import pytest
from legs_bench import BRISK, IN_MID_SHIFT, IN_MID_SWING, Walk, make_plan

from controllers.gait.leg_postures import mismatch
from rig.assembly import Backend
from rig.runtime.phases import Phase, Timings
from rig.runtime.states import RigState

LATE = {50, 333, 600}
"""Cycles after which the loop comes late, in approach, swing and shift."""


class LateClock:
    """A clock on which some cycles take three periods and a half longer than they should."""

    def __init__(self, clock, period):
        self._clock = clock
        self._period = period
        self._calls = 0

    def now(self):
        return self._clock.now()

    def sleep_until(self, t):
        self._clock.sleep_until(t)
        self._calls += 1
        if self._calls in LATE:
            self._clock.sleep_until(t + 3.5 * self._period)


def check_walked(walk, plan):
    """The commands are the plan's samples, none twice and none left out, up to its end."""
    commands = walk.joints("command.position")[walk.column("phase") == Phase.RUN]
    assert len(plan.q) - 3 < len(commands) < len(plan.q)  # rounding of times may leave one more
    np.testing.assert_array_equal(commands, plan.q[: len(commands)])
    np.testing.assert_array_equal(walk.joints("applied.position")[-1], plan.q[-1])


@pytest.fixture(scope="module")
def on_time():
    return Walk(make_plan("legs-walk", *BRISK))


def test_run_is_the_plan(on_time):
    plan = on_time.plan.motion.plan
    assert on_time.outcome.missed == 0
    check_walked(on_time, plan)


def test_late_cycles_hold_the_path_and_lose_nothing(on_time):
    plan = on_time.plan
    late = Walk(plan, clock=lambda clock: LateClock(clock, plan.profile.loop.period))
    assert late.outcome.missed == 3 * len(LATE)
    assert late.outcome.fault is None
    check_walked(late, plan.motion.plan)
    assert late.truth_after["truth.advance"] == pytest.approx(
        on_time.truth_after["truth.advance"], abs=2e-3
    )


@pytest.mark.parametrize(
    ("at", "presses"),
    [(IN_MID_SWING, 1), (IN_MID_SHIFT, 1), (IN_MID_SHIFT, 2)],
    ids=["swing", "shift", "shift, at once"],
)
def test_stop_in_mid_walk_leaves_the_robot_standing(at, presses):
    def press(_, stop):
        for _ in range(presses):
            stop.request()

    walk = Walk(make_plan("legs-walk", *BRISK), at, press)
    assert (walk.outcome.stopped, walk.outcome.fault) == (presses, None)
    assert walk.states.state is RigState.IDLE
    assert walk.truth_after["truth.fell"] == 0.0
    assert walk.truth_after["truth.waist_z"] == pytest.approx(
        walk.column("truth.waist_z")[-1], abs=2e-3
    )


def test_stop_keeps_both_feet_where_they_are():
    """Near the greatest speed, where joints that brake one by one would tear the legs apart."""
    plan = make_plan("legs-walk", "reference.landings=2", "reference.speed=9", "law=sc-trapezoid")
    made = plan.motion.plan
    phase = made.phases[4]
    assert phase.phase.name == "shift 2"
    middle = 0.5 * (phase.first + phase.last) * made.period
    walk = Walk(plan, middle, lambda _, stop: stop.request(), backend=Backend.SIM)
    stopping = walk.joints("applied.position")[walk.column("phase") == Phase.STOP]
    feet = np.broadcast_to(made.feet[phase.first + 1], (len(stopping), 2, 3))
    assert np.ptp(stopping, axis=0).max() > np.radians(2.0)
    assert mismatch(made.geometry, stopping, feet, np.zeros_like(feet)).max() < 50e-6
    speeds = np.diff(stopping, axis=0) / made.period
    assert np.abs(np.diff(speeds, axis=0)).max() <= np.abs(speeds[0]).max()
    assert not speeds[-1].any()
    assert walk.truth_after["truth.fell"] == 0.0


# On the way to the walk ---------------------------------------------------------------------

QUICK = Timings(energise=0.1, approach=0.5)
"""From 0.19 m to straight knees in half a second: the knees go up to 2.7 rad/s."""


def stop_in_approach(rig, at, presses):
    """Stop at an instant of a quick approach, s."""
    plan = make_plan("legs-squat", f"rig={rig}")

    def press(_, stop):
        for _ in range(presses):
            stop.request()

    return Walk(plan, at - QUICK.approach, press, backend=Backend.SIM, timings=QUICK)


@pytest.mark.parametrize("presses", [1, 2], ids=["orderly", "at once"])
@pytest.mark.parametrize(
    "rig",
    [
        "legs-can",
        pytest.param("legs", marks=pytest.mark.slow),
        pytest.param("legs-balance", marks=pytest.mark.slow),
    ],
)
def test_a_stop_on_the_way_to_the_walk_leaves_the_robot_standing(rig, presses):
    for at in np.random.default_rng(0xA9).uniform(0.02, 0.98, 12) * QUICK.approach:
        walk = stop_in_approach(rig, at, presses)
        told = f"stopped at {at:.3f} s of the approach"
        assert (walk.outcome.stopped, walk.outcome.fault) == (presses, None), told
        assert walk.truth_after["truth.fell"] == 0.0, told
        tilt = max(abs(walk.truth_after[f"truth.waist_{angle}"]) for angle in ("roll", "pitch"))
        assert tilt < np.radians(1.5), told


def test_a_stop_on_the_way_to_the_walk_stays_on_that_way():
    walk = stop_in_approach("legs-can", 0.25, 1)
    phase, sent = walk.column("phase"), walk.joints("applied.position")
    way = walk.plan.motion.plan.q[0] - sent[0]
    longest = np.argmax(np.abs(way))
    share = (sent[:, longest] - sent[0, longest]) / way[longest]
    np.testing.assert_allclose(sent, sent[0] + np.outer(share, way), atol=1e-9)
    assert 0.1 < share[phase == Phase.APPROACH][-1] < share[-1] < 1.0
    speeds = np.diff(sent, axis=0) / walk.period
    assert np.abs(np.diff(speeds[phase[1:] == Phase.STOP], axis=0)).max() <= 40.0 * walk.period
    assert not speeds[-1].any()
