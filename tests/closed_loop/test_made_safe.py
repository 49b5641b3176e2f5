"""A rig is safe when its monitors say so: air that stays behind a regulator is named and told."""

import random
import re
from functools import cache
from pathlib import Path

import pytest

import rig.experiment.run as running
from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan
from rig.run_folder import RunFolder
from rig.runtime.phases import Timings

CONFIGS = Path(__file__).parents[2] / "configs"
DRAWN = random.Random(4711)
OPTIONS = {
    "cylinder": ("reference.tones=[{frequency: 2 Hz, periods: 2}]", "reference.amplitude=2 mm"),
    "joint": ("reference.tones=[{frequency: 1 Hz, laps: 1}]",),
}
EXPERIMENT = {"cylinder": "cylinder-sine", "joint": "joint-circle"}
CHANNELS = {"cylinder": ("agonist", "antagonist"), "joint": ("ch1", "ch2", "ch3", "ch4")}


def plan_of(name, *options):
    options = (*OPTIONS[name], "approach=1 s", "metrics={}", "figures=[]", *options)
    return load_plan(EXPERIMENT[name], list(options), configs=CONFIGS)


@cache
def release_of(name, backend):
    """Return the rig's time when the release begins, s: energised, approached, moved, braked."""
    plan, timings = plan_of(name), Timings()
    with build_rig(plan.profile, backend) as rig:
        rig.arm()
        start = rig.clock.now()
    moved = start + timings.energise + plan.experiment.approach + plan.motion.duration
    return moved + timings.brake + timings.settle


def run(folder, monkeypatch, name, backend, *faults, pause=None):
    """Return the result, its events, and the true pressures when the program had ended.

    `pause`: when the host does nothing for a while, and for how long, s.
    """
    built = []
    start = release_of(name, backend)

    def build(*arguments):
        built.append(build_rig(*arguments))
        if pause is not None:
            be_late(built[-1].clock, start + pause[0], pause[1])
        return built[-1]

    monkeypatch.setattr(running, "build_rig", build)
    listed = ", ".join(
        f"{{at: {start + at}, device: {device}, fault: {fault}, value: {value}}}"
        for at, device, fault, value in faults
    )
    plan = plan_of(name, f"simulation.faults=[{listed}]")
    result = running.run_experiment(plan, backend, folder, report=False)
    names = [column.name for column in built[0].truth_columns]
    truth = dict(zip(names, built[0].truth(), strict=True))
    pressures = {channel: truth[f"truth.pressure_{channel}"] for channel in CHANNELS[name]}
    unsafe = [e for e in RunFolder.open(result.path).events() if e["kind"] == "unsafe"]
    return result, unsafe, pressures


def be_late(clock, at, duration):
    """Have one sleep of a clock, the first after some time, take longer; all in s."""
    sleep, left = clock.sleep_until, [duration]

    def sleep_until(t):
        sleep(t + (left.pop() if left and t > at else 0.0))

    clock.sleep_until = sleep_until


def draw(count):
    for _ in range(count):
        name = DRAWN.choice(["cylinder", "joint"])
        yield (
            name, DRAWN.choice([Backend.SIM, Backend.VIRTUAL]),
            DRAWN.randrange(len(CHANNELS[name])), DRAWN.uniform(0.0, 0.3),
        )  # fmt: skip


@pytest.mark.parametrize(("name", "backend", "channel", "at"), list(draw(8)))
def test_air_behind_a_closed_regulator_is_not_called_safe(
    tmp_path, monkeypatch, name, backend, channel, at
):
    result, unsafe, pressures = run(
        tmp_path, monkeypatch, name, backend, (at, "plant", "regulator_closed", channel)
    )
    where = CHANNELS[name][channel]
    assert pressures.pop(where) > 20e3
    assert max(pressures.values()) < 20e3
    assert (result.exit_code, result.status.value) == (4, "faulted")
    (event,) = unsafe
    assert f"regulators: {where} still holds" in event["message"]
    assert "kPa" in event["message"]
    for other in pressures:
        assert f" {other} still" not in event["message"]
    if not any(e["kind"] == "fault" for e in RunFolder.open(result.path).events()):
        assert result.message == f"not made safe: {event['message']}"


@pytest.mark.parametrize("name", ["cylinder", "joint"])
@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_run_ends_only_when_its_chambers_have_vented(tmp_path, monkeypatch, name, backend):
    result, unsafe, pressures = run(tmp_path, monkeypatch, name, backend)
    assert (result.exit_code, unsafe) == (0, [])
    assert max(pressures.values()) < 21e3


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_what_does_not_answer_is_not_known_to_be_safe(tmp_path, monkeypatch, backend):
    at = DRAWN.uniform(-3.0, 0.3)
    result, unsafe, _ = run(
        tmp_path, monkeypatch, "cylinder", backend, (at, "regulators", "silent", 60.0)
    )
    assert result.exit_code == 4
    (event,) = unsafe
    assert "regulators: not known to be safe, its last reading is 1.0" in event["message"]
    for channel in CHANNELS["cylinder"]:
        assert re.search(rf"{channel} held \d+\.\d kPa", event["message"])


@pytest.mark.parametrize("name", ["cylinder", "joint"])
def test_a_broken_wire_is_why_nothing_is_known_of_the_chambers(tmp_path, monkeypatch, name):
    channel = DRAWN.randrange(len(CHANNELS[name]))
    broken = (DRAWN.uniform(-3.0, 0.3), "regulators", "wire_break", channel)
    result, unsafe, _ = run(tmp_path, monkeypatch, name, Backend.VIRTUAL, broken)
    assert result.exit_code == 4
    (event,) = unsafe
    where = CHANNELS[name][channel]
    assert "regulators: not known to be safe, its last reading is" in event["message"]
    assert f"the pressure monitor of {where} has a broken wire" in event["message"]


@pytest.mark.parametrize("name", ["cylinder", "joint"])
def test_a_module_that_stopped_itself_is_asked_for_what_its_chambers_hold(
    tmp_path, monkeypatch, name
):
    """It missed the heartbeat of a host that paused, and samples nothing any more."""
    channel = DRAWN.randrange(len(CHANNELS[name]))
    closed = (-0.52, "plant", "regulator_closed", channel)
    result, unsafe, pressures = run(
        tmp_path, monkeypatch, name, Backend.VIRTUAL, closed, pause=(-0.5, 0.3)
    )
    where = CHANNELS[name][channel]
    assert pressures.pop(where) > 20e3
    assert result.exit_code == 4
    assert "the program was paused" in result.message
    (event,) = unsafe
    assert f"regulators: {where} still holds" in event["message"]
    assert max(pressures.values()) < 20e3
