"""A drive that fails in mid-path: the arm slows down, the error says what, the log says how.

On production drivers and emulated drives of both kinds of bus. Rates and decelerations are the
plant's own.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend
from rig.config.simulation_models import FaultSpec
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

CONFIGS = Path(__file__).parents[2] / "configs"
AT = 4.0
"""s on the rig's clock: about a second after the motion began."""
PERIOD = 5e-3
LIMITS = np.array((10.0, 10.0, 10.0, 20.0, 20.0, 20.0))
"""The arm's acceleration limits, rad/s²."""
NODE = ("drives joint q3", "(node 0x03)")
STUCK = ("way that drives joint q3 was sent and does not go", "outside 0 …")
FAULTS = [
    # rig, fault, seen within s, words of the message
    (
        "arm",
        "drive_fault",
        0.02,
        (*NODE, "reports a fault", "over-current", "error code 0x2310", "status word 0x"),
    ),
    (
        "arm",
        "heartbeat_silent",
        0.2,
        (*NODE, "heartbeat is lost", "OPERATION ENABLED", "bound 0.15 s"),
    ),
    ("arm", "stuck", 0.4, STUCK),
    (
        "arm-odrive",
        "drive_fault",
        0.11,
        (*NODE, "over-voltage of the DC bus", "0x00000100", "(IDLE)"),
    ),
    (
        "arm-odrive",
        "heartbeat_silent",
        0.2,
        (*NODE, "heartbeat is lost", "CLOSED LOOP", "bound 0.1 s"),
    ),
    ("arm-odrive", "stuck", 0.4, STUCK),
]


@cache
def make_plan(rig, *options):
    """Return the plan of the elbow's circle, made once."""
    slow = ["approach=1 s", "reference.rate=0.5 rad/s", "metrics={}"]
    return load_plan("arm-elbow-circle", [*slow, *options], rig=rig, configs=CONFIGS)


def run_into(rig, fault, folder, *options):
    """Run into a fault of q3 on the elbow's circle."""
    plan = make_plan(rig, *options)
    simulation = replace(plan.profile.simulation, faults=(FaultSpec(AT, "drives", f"q3.{fault}"),))
    plan = plan._replace(profile=replace(plan.profile, simulation=simulation))
    return run_experiment(plan, Backend.VIRTUAL, folder, report=False)


@pytest.fixture(scope="module", params=FAULTS, ids=lambda case: "-".join(case[:2]))
def failed(request, tmp_path_factory):
    rig, fault, within, words = request.param
    result = run_into(rig, fault, tmp_path_factory.mktemp(f"{rig}-{fault}"))
    return result, read_log(RunFolder.open(result.path).log_path), within, words


def rates(log):
    return np.column_stack([log.column(f"truth.q{k}_velocity") for k in range(1, 7)])


def test_error_names_joint_node_and_what_the_drive_says(failed):
    result, _, _, words = failed
    assert (result.exit_code, result.status.value) == (4, "faulted")
    for word in words:
        assert word in result.message


@pytest.mark.parametrize(
    ("rig", "rate", "words"),
    [
        ("arm", 0.5, ("following error", "error code 0x8611", "status word 0x")),
        ("arm-odrive", 0.5, ("does not follow its reference", "rad", "for 0.1 s")),
        # At full speed it is too far from where it was sent before the drive loses patience.
        ("arm", 0.95, ("distance of q3 from where it was sent", "0 … 8.594 deg", "status word 0x")),
    ],
)
def test_joint_that_may_stand_behind_is_told_by_what_is_seen_next(rig, rate, words, tmp_path):
    options = (f"reference.rate={rate} rad/s", "arm.limits.stuck=1 rad")
    result = run_into(rig, "stuck", tmp_path, *options)
    for word in (*NODE, *words):
        assert word in result.message


def test_fault_is_latched_and_told(failed):
    result, _, _, _ = failed
    events = RunFolder.open(result.path).events()
    states = [event["data"]["new"] for event in events if event["kind"] == "state"]
    assert states[-1] == "fault"
    assert [event["message"] for event in events if event["kind"] == "fault"] == [result.message]


def test_log_is_complete_to_standstill(failed):
    result, log, within, _ = failed
    told = next(e["t"] for e in RunFolder.open(result.path).events() if e["kind"] == "fault")
    (stopping,) = np.nonzero(log.column("phase") == 2.0)
    assert stopping[0] > 0
    assert log.t[stopping[0] - 1] == pytest.approx(told, abs=1e-6), "the cycle that saw it"
    connecting = 1.5  # s that the rig's clock is ahead of the log's at most
    assert AT - connecting < told < AT + within
    assert (np.diff(log.cycle) == 1).all(), "no cycle is missing"
    assert np.abs(rates(log)[-1]).max() < 1e-3, "at rest when it ends"


def test_other_joints_stop_under_their_deceleration_limit(failed):
    _, log, _, _ = failed
    last = int(np.flatnonzero(log.column("phase") == 2.0)[0])
    v = rates(log)
    # One that is nearly at rest is pushed by q3, whose ODrive lets go of it at once.
    moving = np.abs(v[last - 1]) > 0.3
    moving[2] = False
    assert moving.sum() >= 2, "the arm was in motion"
    accelerations = np.abs(np.diff(v[last - 1 :], axis=0)).max(axis=0) / PERIOD
    assert (accelerations <= LIMITS)[moving].all()
    # They brake, and do not coast: at half the limit they would still be moving.
    at_rest = round(np.abs(v[last - 1]).max() / (0.5 * LIMITS.min()) / PERIOD)
    assert (np.abs(v[last + at_rest :, moving]) < 0.05).all()
