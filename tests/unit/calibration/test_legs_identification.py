"""The legs' zeros and scales from made-up readings in a jig; and who puts them there."""

import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from controllers.gait.geometry import AXIS_NAMES
from rig.assembly import REGISTRY, Backend
from rig.calibration import session
from rig.calibration.catalogue import procedures
from rig.calibration.instruments import made_to
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import find_configs, load_profile
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.run_facts import RunStatus
from rig.runtime.log import Log

TOLERANCE = math.radians(0.1)
KNEE = AXIS_NAMES.index("left_knee")


@pytest.fixture(scope="module")
def profile():
    return load_profile("legs", REGISTRY, (), find_configs())


def recording(poses, shake=0.0):
    """Make a recording of a second in each pose; `poses` maps names to twelve angles."""
    rows = 50
    t = np.arange(len(poses) * rows) / rows
    angles = np.repeat(np.array(list(poses.values())), rows, axis=0)
    angles[:, KNEE] += shake * np.sin(40.0 * t)
    columns = ("phase", "reference.time", *(f"reading.position_{j}" for j in AXIS_NAMES))
    log = Log(
        tuple(Column(name, "", "") for name in columns),
        np.arange(len(t), dtype=np.uint64), t,
        np.column_stack([np.ones_like(t), t, angles]), np.zeros(len(t), np.uint64), True,
    )  # fmt: skip
    return Recording([(log, [Segment(name, k, k + 1.0) for k, name in enumerate(poses)])])


def jig_of(profile, procedure):
    instruments = procedures(profile)[procedure].instruments(profile)
    readings = made_to(instruments)
    names = instruments[0].stretches
    return readings, {n: [readings[f"angle {j}"][n] for j in AXIS_NAMES] for n in names}


def identify(profile, procedure, seen, readings, **how):
    chosen = procedures(profile)[procedure]
    (finding,) = chosen.identify(profile, recording(seen, **how), readings)
    return finding, {e.name: e for e in finding.estimates}


def test_zeros_are_what_the_jig_says_more(profile):
    readings, poses = jig_of(profile, "zeros")
    seen = {name: [angle - 0.05 for angle in pose] for name, pose in poses.items()}
    finding, found = identify(profile, "zeros", seen, readings)
    knee = found["left_knee.offset"]
    assert knee.value == pytest.approx(0.05)
    step = 2.0 * math.pi / 4096
    assert knee.std == pytest.approx(math.hypot(TOLERANCE, step / math.sqrt(12.0)))
    assert finding.values["joints"]["left_knee"] == {"offset": "0.05 rad"}


def test_scale_direction_and_zero(profile):
    readings, poses = jig_of(profile, "scale")
    seen = {name: [-(1.02 * angle) - 0.03 for angle in pose] for name, pose in poses.items()}
    finding, found = identify(profile, "scale", seen, readings)
    assert found["right_hip_yaw.scale"].value == pytest.approx(1.0 / 1.02)
    assert found["right_hip_yaw.offset"].value == pytest.approx(-0.03 / 1.02)
    values = finding.values["joints"]["right_hip_yaw"]
    assert values["reversed"] is True
    assert values["gear"] == pytest.approx(1.02)
    assert finding.panels[0].y.max() < 100.0  # mrad: the direction is not in the picture


def test_a_joint_that_is_loose_in_the_jig_is_named(profile):
    readings, poses = jig_of(profile, "zeros")
    with pytest.raises(CalibrationRefused, match=r"left_knee moved by 0\.0\d+ rad in 'straight'"):
        identify(profile, "zeros", poses, readings, shake=0.01)


def test_an_encoder_that_did_not_turn_is_named(profile):
    readings, poses = jig_of(profile, "scale")
    frozen = {name: [*pose[:KNEE], 0.0, *pose[KNEE + 1 :]] for name, pose in poses.items()}
    with pytest.raises(CalibrationRefused, match="left_knee: its encoder went through 0 deg"):
        identify(profile, "scale", frozen, readings)


def test_a_horn_that_is_mounted_beyond_the_servo_s_turn_is_refused(profile):
    readings, poses = jig_of(profile, "zeros")
    seen = {name: [angle + 2.0 for angle in pose] for name, pose in poses.items()}
    with pytest.raises(CalibrationRefused, match="Mount the horn so that"):
        identify(profile, "zeros", seen, readings)


def test_too_few_poses_say_which_are_missing(profile):
    readings, poses = jig_of(profile, "scale")
    seen = {"straight": poses["straight"]}
    with pytest.raises(
        CalibrationRefused, match=r"2 of 3 stretches are missing.*crouched, splayed"
    ):
        identify(profile, "scale", seen, readings)


def test_each_pose_is_a_run_of_its_own_and_waits_for_somebody(profile, monkeypatch, tmp_path):
    """With nobody there after the first pose, the rest is not recorded."""
    procedure = procedures(profile)["scale"]
    done, ran, told = [], [], []

    def run(plan, *_, **__):
        (segment,) = plan.motion.segments
        assert not plan.motion.has_torque
        ran.append(segment.name)
        done.append(segment.name)
        return SimpleNamespace(path=tmp_path / segment.name, status=RunStatus.OK)

    monkeypatch.setattr(session, "run_experiment", run)
    monkeypatch.setattr(session.Recording, "of", lambda folders: SimpleNamespace(names=(*done,)))

    def place(what):
        told.append(what)
        return len(told) < 3

    whole = partial(
        session.record, procedure, profile, Backend.HARDWARE, tmp_path, uncommissioned="a test"
    )
    _, folders = whole(place=place)
    assert ran == ["straight", "crouched"]
    assert told[2] == "put both legs into the jig's pose 'splayed', without torque"
    _, folders = whole(earlier=folders)
    assert ran == ["straight", "crouched", "splayed"]
    assert len(folders) == 3
