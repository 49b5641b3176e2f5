"""Plans in Python: steps that are checked, branches, marks, and every way to be wrong."""

import math
import os
import random
import signal
import sys
import threading
import time

import numpy as np
import pytest

import rig
from rig.hal import MotionRefused
from rig.run_facts import RunStatus
from rig.runtime.log import read_log

FAST = {"approach": 0.3}


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return tmp_path_factory.mktemp("plans")


def follow(plan, out, on="sim", **more):
    return rig.run("cylinder-ideal-staircase", on=on, plan=plan, set=FAST, out=out, **more)


def levels(r):
    for level in (2e-3, -3e-3):
        r.mark(f"to {level * 1e3:g} mm")
        yield r.move(level, 0.4)
        if not (yield r.settle(0.2e-3, within=2.0)):
            return
        if r.reading("agonist") > 400e3:
            return
    yield r.follow(lambda t: -3e-3 + 2e-3 * math.sin(2 * t) ** 2, 1.0)
    yield r.step(0.0, 0.5)
    yield r.hold(0.2)


@pytest.fixture(scope="module", params=["sim", "virtual"])
def followed(request, out):
    return follow(levels, out, request.param)


def test_a_plan_is_followed_step_by_step(followed):
    names = [segment.name for segment in followed.segments]
    assert names == ["all", "to 2 mm", "to -3 mm"]
    told = [event["message"] for event in followed.events if event["kind"] in ("plan", "mark")]
    assert told[:3] == [
        "to 2 mm", "move to 0.002 in 0.4 s", "wait until settled to 0.0002, 2 s at most",
    ]  # fmt: skip
    data = followed.data[followed.data["phase"] == 1]
    assert np.max(data["reference.position"]) == pytest.approx(2e-3)
    assert np.min(data["reference.position"]) == pytest.approx(-3e-3)
    marks = {segment.name: segment for segment in followed.segments}
    second = marks["to -3 mm"].start
    settled = np.abs(data["reference.position"] - data["reading.position"])
    before = (data["reference.time"] > second - 0.2) & (data["reference.time"] < second)
    assert np.all(settled[before] <= 0.2e-3)
    assert "def levels(r):" in (followed.path / "code" / "levels.py").read_text()
    assert followed.status is RunStatus.OK
    assert followed.metrics["pressure_min"].bound is None


def test_the_speed_of_a_path_is_its_slope(followed):
    data = followed.data[followed.data["phase"] == 1]
    position, velocity = data["reference.position"], data["reference.velocity"]
    jumps = np.abs(np.gradient(position, data["reference.time"]) - velocity) > 1e-3
    assert np.mean(jumps) < 0.01  # but at the sudden step


def test_the_joint_takes_tilt_and_azimuth(out):
    def poses(r):
        yield r.move((math.radians(8), 1.0), 1.0)
        yield r.settle(math.radians(1))

    run = rig.run("joint-poses", on="sim", plan=poses, set={"approach": 1.0}, out=out)
    assert run.status == "ok"
    axis = [run.data[f"reference.{name}"][-400] for name in ("axis_x", "axis_y")]
    wanted = math.sin(math.radians(8)) * np.array([math.cos(1.0), math.sin(1.0)])
    assert axis == pytest.approx(wanted, abs=0.02)


def test_the_arm_takes_its_axes(out):
    def turn(r):
        here = r.goal.positions
        yield r.move([here[0] + 0.2, *here[1:]], 1.0)

    run = rig.run("arm-wrist-hit", on="sim", plan=turn, out=out)
    data = run.data[run.data["phase"] == 1]
    assert np.ptp(data["reference.position_q1"]) == pytest.approx(0.2, rel=1e-3)


def test_legs_say_that_they_cannot(out):
    with pytest.raises(rig.ConfigurationError, match="legs cannot be sent by numbers"):
        rig.run("legs-squat", on="sim", plan=levels, out=out)


# What is refused --------------------------------------------------------------------------


def too_far(r):
    yield r.move(0.5, 1.0)


def too_fast(r):
    yield r.move(5e-3, 1e-3)


def no_step(r):
    yield 5


def no_plan(r):
    return 5


def divides(r):
    yield r.hold(0.01)
    yield r.move(1 / r.t * 0.0 / 0.0, 1.0)


def no_number(r):
    yield r.move("far", 1.0)


def not_a_number(r):
    yield r.move(math.nan, 1.0)


def unknown(r):
    yield r.hold(0.01)
    r.reading("presure")


def elsewhere(r):
    yield r.follow(lambda t: 5e-3, 1.0)


def never(r):
    while True:
        yield r.hold(1.0)


def backwards(r):
    yield r.move(1e-3, -1.0)


def leaves(r):
    yield r.hold(0.01)
    sys.exit(7)


def nested(r):
    yield r.hold(0.01)
    rig.run("cylinder-ideal-step", on="sim")


def no_plan_but_a_run(r):
    rig.run("cylinder-ideal-step", on="sim")


def swept(r):
    yield r.hold(0.01)
    rig.sweep("cylinder-ideal-step", seeds=range(2), on="sim")


def calibrates(r):
    yield r.hold(0.01)
    rig.calibrate("cylinder", "friction", on="sim")


@pytest.mark.parametrize(
    ("plan", "said"),
    [
        (too_far, "line .*500 mm is outside limits.position"),
        (too_fast, "line .*more than limits.speed"),
        (no_step, "it yields 5, which is no step"),
        (no_plan, "it returns 5; a plan yields steps"),
        (divides, "line .*ZeroDivisionError"),
        (no_number, "line .*'far' is no target, which is position of the pair"),
        (not_a_number, "line .*nan mm is outside"),
        (unknown, "no reading 'presure'; there are t, position"),
        (elsewhere, "starts 0.00.* away from where the rig is"),
        (never, "takes longer than 3 s"),
        (backwards, "the duration of a move is -1.0"),
        (leaves, "line .*it wants to end the program .SystemExit: 7"),
        (nested, "line .*rig.run within the plan nested: its own run goes on"),
        (no_plan_but_a_run, "line .*rig.run within the plan no_plan_but_a_run"),
        (swept, "line .*rig.sweep within the plan swept"),
        (calibrates, "line .*rig.calibrate within the plan calibrates"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_moves(out, plan, said):
    before = set(out.iterdir())
    with pytest.raises(MotionRefused, match=f"(?s)rehearsal.*{plan.__name__}.*{said}"):
        follow(plan, out, "virtual", most=3.0)
    assert set(out.iterdir()) == before


def test_what_the_rehearsal_did_not_meet_is_checked_while_the_rig_waits(out):
    def other_way(r):
        yield r.hold(0.1)
        yield r.move(3e-3 if r.rehearsing else -3e-3, 0.5)

    run = follow(other_way, out, "virtual")
    data = run.data[run.data["phase"] == 1]
    assert np.min(data["reference.position"]) == pytest.approx(-3e-3)
    assert data["reference.time"][-1] > 0.6 + 40 * 1e-3  # it was checked first, cycle by cycle


def test_what_the_rehearsal_did_not_meet_is_refused_in_time(out):
    def out_of_reach(r):
        yield r.hold(0.1)
        yield r.move(3e-3 if r.rehearsing else 0.5, 0.5)

    with pytest.raises(rig.RunFaulted, match="500 mm is outside") as faulted:
        follow(out_of_reach, out, "virtual")
    truth = faulted.value.run.data["truth.position"]
    assert np.max(np.abs(truth)) < 20e-3


def test_a_simulated_fault_is_not_rehearsed(out):
    fault = "[{at: 1.6, device: regulators, fault: emergency_stop}]"
    with pytest.raises(rig.RunFaulted, match="emergency stop"):
        rig.run("cylinder-ideal-staircase", on="virtual", plan=levels, out=out,
                set={**FAST, "simulation.faults": fault})  # fmt: skip


def test_a_run_may_follow_a_plan_that_wanted_one(out):
    with pytest.raises(rig.RunFaulted, match=r"rig\.run within the plan nested"):
        follow(nested, out)
    assert rig.run("cylinder-ideal-staircase", on="sim", set=FAST, out=out).status == "ok"


def test_the_end_of_the_program_that_a_plan_wants_is_a_fault_made_safe(out):
    with pytest.raises(rig.RunFaulted, match=r"line \d+: it wants to end the program"):
        follow(leaves, out)


@pytest.mark.parametrize("seed", range(3))
def test_only_steps_of_a_plan_have_a_step_response(out, seed):
    drawn = random.Random(seed)
    near, far = drawn.uniform(1e-3, 2e-3), drawn.uniform(3e-3, 4e-3)

    def moves(r):
        r.mark("go")
        yield r.move(near, 0.4)
        r.mark("stay")
        yield r.hold(0.5)

    def steps(r):
        yield from moves(r)
        r.mark("jump")
        yield r.step(far, 1.0)

    smooth, sudden = (rig.run("cylinder-ideal-step", on="sim", plan=plan, set=FAST, out=out)
                      for plan in (moves, steps))  # fmt: skip
    assert not {"overshoot", "rise_time", "settling_time"} & set(smooth.metrics)
    assert "pressure_min" in smooth.metrics
    data = sudden.data[sudden.data["phase"] == 1]
    jump = data[data["reference.position"] == far]
    start = jump["reading.position"][0]
    share = (jump["reading.position"].max() - start) / (far - start) - 1.0
    assert sudden.metrics["overshoot"].value == pytest.approx(max(share, 0.0), abs=2e-3)


# Interrupts -------------------------------------------------------------------------------


def wanders(r):
    for k in range(10):
        yield r.move(4e-3 * math.sin(k), 0.15)
        yield r.settle(1e-3, within=0.2, still=0.05)


def interrupted(out, delay, twice):
    """Run the plan; interrupt this process after `delay` seconds. Return the error."""

    def kill():
        for _ in range(1 + twice):
            os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(delay, kill)
    before = set(out.iterdir())
    timer.start()
    try:
        follow(wanders, out)
        timer.join()
    except KeyboardInterrupt as error:
        timer.join()
        return error, set(out.iterdir()) - before
    return None, set(out.iterdir()) - before


def endless(r):
    yield r.move(random.Random(3).uniform(1e-3, 4e-3), 0.1)
    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
    threading.Timer(1.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    while True:
        r.reading("position")


def test_a_plan_that_computes_without_end_is_ended_by_a_second_interrupt(out):
    with pytest.raises(rig.RunInterrupted, match="in a cycle that did not end") as caught:
        follow(endless, out)
    assert caught.value.run.status is RunStatus.ABORTED and caught.value.run.manifest["ended"]
    assert read_log(caught.value.run.path / "log.mcap").complete


@pytest.mark.parametrize(
    "count", [8, pytest.param(500, marks=[pytest.mark.slow, pytest.mark.lengthy])], ids=["8", "500"]
)
def test_an_interrupt_leaves_the_rig_safe_and_the_folder_closed(out, count):
    drawn = random.Random(20)
    follow(wanders, out)  # everything is imported and compiled
    began = time.perf_counter()
    follow(wanders, out)
    takes = time.perf_counter() - began
    hit = 0
    for _ in range(count):
        try:
            error, folders = interrupted(out, drawn.uniform(0.0, takes), drawn.random() < 0.3)
        except KeyboardInterrupt:
            continue  # it came while nothing ran
        for folder in folders:
            run = rig.load(folder)
            assert run.status in (RunStatus.OK, RunStatus.ABORTED), run
            assert run.manifest["ended"]
            assert "not made safe" not in (run.message or "")
        if isinstance(error, rig.RunInterrupted):
            hit += 1
            assert isinstance(error, rig.RigError)
            assert np.max(np.abs(error.run.data["truth.position"]), initial=0.0) < 20e-3
    assert hit > count / 10  # the others came while it was planned, or after its end
