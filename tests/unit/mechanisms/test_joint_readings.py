"""What is read of the joint, whose readings are too old, and what the log keeps."""

import math

import pytest
from joint_fakes import (
    ENCODERS,
    GEOMETRY,
    JointBench,
    joint_settings,
    rods_at,
)
from pneumatic_fakes import (
    AGE,
    TINY,
    FakeCamera,
)

from controllers.spherical_joint.types import JointCommand, JointEstimate, JointReference, Lap
from rig.hal import EmergencyStop, Markers, StaleReading

UP = (0.0, 0.0, 1.0)


def test_rods_count_from_their_own_homes_and_grow_as_they_come_in():
    offsets = (2.0**-12, 0.0, -(2.0**-12), 0.0)
    bench = JointBench(joint_settings(wire_offsets=offsets))
    bench.place((0.0, 2.0**-8, 0.0, -(2.0**-8)))
    bench.regulators.reads = (1.0, 2.0, 3.0, 4.0)
    state = bench.joint.read(0.0)
    assert state == (0.0, (2.0**-12, 2.0**-8, -(2.0**-12), -(2.0**-8)), (1.0, 2.0, 3.0, 4.0), None)


def test_readings_may_be_as_old_as_their_limit():
    bench = JointBench()
    bench.refresh(1.0 - AGE)
    bench.joint.read(1.0)


@pytest.mark.parametrize("oldest", ["regulators", *ENCODERS])
def test_the_device_with_the_oldest_reading_is_blamed(oldest):
    for others, its in ((0.0, AGE + TINY), (2.0 * AGE, 3.0 * AGE)):
        bench = JointBench()
        bench.refresh(1.0 - others)
        for device in (bench.regulators, *bench.encoders):
            if device.name == oldest:
                device.t = 1.0 - its
        with pytest.raises(StaleReading) as caught:
            bench.joint.read(1.0)
        error = caught.value
        assert (error.device, error.age, error.bound) == (oldest, its, AGE)


def test_of_readings_that_are_equally_old_the_first_device_is_blamed():
    bench = JointBench()
    with pytest.raises(StaleReading, match=r"^regulators: "):
        bench.joint.read(1.0)
    bench.regulators.t = 1.0
    with pytest.raises(StaleReading, match=r"^e1: "):
        bench.joint.read(1.0)


def test_the_emergency_stop_is_heeded_before_anything_else():
    bench = JointBench()
    bench.place((math.nan,) * 4)
    bench.stop.pressed, bench.stop.t = True, -9.0
    with pytest.raises(EmergencyStop, match="pressed or its circuit is open"):
        bench.joint.check(bench.joint.read(0.0), 0.0)


def test_a_stop_that_is_not_read_any_more_is_a_fault_of_its_own():
    bench = JointBench()
    bench.stop.t = -AGE
    bench.joint.check(bench.joint.read(0.0), 0.0)
    bench.stop.t = -AGE - TINY
    with pytest.raises(StaleReading) as caught:
        bench.joint.check(bench.joint.read(0.0), 0.0)
    error = caught.value
    assert (error.device, error.age, error.bound) == (
        "the emergency stop that stop reads",
        AGE + TINY,
        AGE,
    )


def test_a_camera_sample_stays_until_the_next_and_goes_with_the_marker():
    camera = FakeCamera()
    bench = JointBench(camera=camera)
    assert bench.joint.read(0.0).camera is None
    camera.t, camera.sees = 0.25, Markers((0, 1), ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0)), (0.5, 0.1))
    sample = bench.joint.read(0.0).camera
    assert sample == ((1.0, 2.0, 3.0), 0.25, 0.5)
    assert bench.joint.read(0.001).camera is sample
    camera.t, camera.sees = 0.5, Markers((0,), ((4.0, 5.0, 6.0),))
    assert bench.joint.read(0.002).camera == ((4.0, 5.0, 6.0), 0.5, None)
    camera.sees = Markers((), ())
    assert bench.joint.read(0.003).camera is None


# The log ---------------------------------------------------------------------------------------


class Learning:
    def __init__(self, active, finished):
        self.active, self.finished = active, finished


class Controller:
    """Believes what a test says."""

    learning = None
    estimate = JointEstimate((1, 2, 3), (4, 5, 6), 7, (8, 9, 10, 11), (0,) * 4)


class Motion:
    pose = (90, 91, 92)


def logged(bench, state, reference=None):
    reference = reference or JointReference(UP, (0.0,) * 3, (0.0,) * 3)
    row = bench.joint.row(state, reference, JointCommand(20, 21, 22, 23), JointCommand(*range(4)))
    columns = [column.name for column in bench.joint.columns]
    return dict(zip(columns, row, strict=True))


def group(row, prefix):
    return tuple(value for name, value in row.items() if name.startswith(prefix))


def test_the_row_has_a_value_for_each_column():
    settings = joint_settings()
    camera = FakeCamera()
    bench = JointBench(settings, camera)
    camera.t, camera.sees = 1.0, Markers((0,), ((1.0, 2.0, 3.0),), (0.5,))
    bench.lean(0.3, 1.0)
    bench.regulators.reads = (10.0, 20.0, 30.0, 40.0)
    bench.joint.controller, bench.joint.motion = Controller(), Motion()
    bench.joint.check(bench.joint.read(0.0), 0.0)
    bench.refresh(2.0 - AGE)
    row = logged(bench, bench.joint.read(2.0))
    assert group(row, "reading.rod_") == pytest.approx(rods_at(0.3, 1.0))
    assert group(row, "reading.pressure_") == (10.0, 20.0, 30.0, 40.0)
    assert row["reading.age"] == AGE
    assert group(row, "reading.marker_") == (1.0, 2.0, 3.0, 1.0, 1.0)
    assert (row["reading.twist"], row["reading.twist_shown"]) == (0.5, 1.0)
    assert group(row, "reference.axis_") == UP
    assert group(row, "reference.marker_") == GEOMETRY.marker(UP)
    assert group(row, "reference.rod_") == (8, 9, 10, 11)
    assert group(row, "estimate.marker_") == (1, 2, 3)
    assert group(row, "estimate.encoder_marker_") == (4, 5, 6)
    assert row["estimate.residual"] == 7
    area = settings.area
    assert group(row, "estimate.tension_") == (10 * area, 20 * area, 30 * area, 40 * area)
    assert group(row, "plan.") == (90, 91, 92)
    assert group(row, "command.") == (20, 21, 22, 23)
    assert group(row, "applied.") == (0, 1, 2, 3)
    assert (row["estimate.lap"], row["estimate.learning"]) == (-1.0, 0.0)


def test_before_the_first_check_nothing_is_estimated():
    bench = JointBench()
    bench.joint.controller = Controller()
    bench.lean(0.3, 1.0)
    row = logged(bench, bench.joint.read(0.0))
    assert group(row, "estimate.marker_") == group(row, "estimate.encoder_marker_") == (0.0,) * 3
    assert group(row, "reference.rod_") == pytest.approx(rods_at(0.3, 1.0))
    assert group(row, "plan.") == (0.0,) * 3
    assert (row["reading.marker_age"], row["reading.twist"]) == (-1.0, 0.0)
    assert row["estimate.residual"] == 0.0


@pytest.mark.parametrize(
    ("learning", "logs"),
    [(None, 0.0), (Learning(False, True), 0.0), (Learning(True, False), 1.0),
     (Learning(True, True), 2.0)],
)  # fmt: skip
def test_the_log_says_whether_laps_are_learnt_from(learning, logs):
    bench = JointBench()
    bench.joint.controller = Controller()
    bench.joint.controller.learning = learning
    reference = JointReference(UP, (0.0,) * 3, (0.0,) * 3, Lap(3, 0, 9))
    row = logged(bench, bench.joint.read(0.0), reference)
    assert (row["estimate.lap"], row["estimate.learning"]) == (3.0, logs)
