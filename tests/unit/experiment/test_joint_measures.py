"""Measures of the camera, of laps and of pushes, on signals whose answers are known."""

import math

import numpy as np
import pytest

from rig.experiment.measure import Samples, Window
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.mechanisms.joint.measures.camera import (
    camera_latency,
    camera_latency_error,
    camera_latency_found,
)
from rig.mechanisms.joint.measures.laps import lap_errors, laps_learnt, learning_gain
from rig.mechanisms.joint.measures.stiffness import pose_stiffness_gain, push_slip, yielding
from rig.mechanisms.joint.measures.tracking import tension_max, tension_min
from rig.runtime.log import Log

PERIOD = 1e-3
CHANNELS = ("ch1", "ch2", "ch3", "ch4")


class Columns:
    """A log's followed part, as a window takes it."""

    def __init__(self, t, columns):
        self.t, self._columns, self.period = t, columns, PERIOD

    def column(self, name):
        return self._columns[name]

    def names(self, prefix):
        return tuple(name for name in self._columns if name.startswith(prefix))


def window(t, columns, name="0.5 Hz"):
    return Window(Segment(name, t[0], t[-1]), Columns(t, columns), slice(0, len(t)))


def circle(t):
    turn = math.pi * t
    return {"x": 18e-3 * np.cos(turn), "y": 18e-3 * np.sin(turn), "z": np.full_like(t, 49e-3)}


def seen(late, hysteresis=0.0):
    """Return a window in which stamps are `late` by so much, s, and samples come after 40 ms."""
    t = np.arange(0.0, 4.0, PERIOD)
    stamp = np.floor((t - 40e-3) * 60.0) / 60.0
    columns = {"reading.marker_age": t - stamp}
    for axis, way in circle(stamp - late).items():
        columns[f"reading.marker_{axis}"] = way + 1e-4  # a camera that is calibrated a little off
    for axis, way in circle(t).items():
        columns[f"truth.marker_{axis}"] = way
    for axis, way in circle(t - hysteresis).items():
        columns[f"estimate.encoder_marker_{axis}"] = way
    return window(t, columns)


@pytest.mark.parametrize("late", [-4e-3, 0.0, 1e-3, 12e-3])
def test_stamps_that_are_late_are_found_out(late):
    assert camera_latency_found([seen(late)]) == pytest.approx(late, abs=2e-5)


def test_what_looks_like_a_delay_to_the_encoders_is_told():
    windows = [seen(1e-3, hysteresis=3e-3)]
    assert camera_latency_found(windows) == pytest.approx(-2e-3, abs=2e-5)
    assert camera_latency_error(windows) == pytest.approx(3e-3, abs=4e-5)


def test_latency_is_the_age_at_first_use():
    assert camera_latency([seen(0.0)]) == pytest.approx(40.5e-3, abs=1e-3)


def test_a_camera_that_sees_nothing_tells_nothing():
    t = np.arange(0.0, 1.0, PERIOD)
    columns = {f"reading.marker_{axis}": np.zeros_like(t) for axis in "xyz"}
    with pytest.raises(ValueError, match="only 0 samples"):
        camera_latency([window(t, {"reading.marker_age": np.full_like(t, -1.0), **columns})])


def pushed(stiffness, slip=0.0):
    t = np.arange(0.0, 2.0, PERIOD)
    force = 4.0 * np.sin(math.tau * t)
    position = force / stiffness + slip * t / t[-1]
    columns = {f"reading.pressure_{name}": np.full_like(t, 0.12e6) for name in CHANNELS}
    columns["estimate.tension_ch1"], columns["estimate.tension_ch3"] = 22.0 + force, 22.0 + 0.0 * t
    columns["reading.rod_ch1"], columns["reading.rod_ch3"] = position, -position
    return window(t, columns, "120 kPa")


def test_stiffness_is_force_over_motion():
    found = yielding(pushed(4e5))
    assert found.stiffness == pytest.approx(4e5, rel=1e-6)
    assert found.pressure == pytest.approx(0.12e6)
    assert found.lag == pytest.approx(0.0, abs=1e-9)
    assert pose_stiffness_gain([pushed(4e5), pushed(5e5)]) == pytest.approx(1.25, rel=1e-6)
    assert push_slip([pushed(4e5), pushed(4e5, slip=5e-6)]) == pytest.approx(5e-6, abs=1e-7)


def repeated(errors, ended):
    """Return laps of 1 s with a given error of ch1's pair and of the marker, m."""
    t = np.arange(0.0, float(len(errors)), PERIOD)
    lap = np.floor(t + 1e-9)
    error = np.array(errors)[lap.astype(int)]
    columns = {"estimate.lap": lap, "estimate.learning": np.where(lap >= ended, 2.0, 1.0)}
    for name, sign in zip(CHANNELS, (1.0, 0.0, -1.0, 0.0), strict=True):
        columns[f"reference.rod_{name}"] = sign * error
        columns[f"reading.rod_{name}"] = np.zeros_like(t)
    for axis in "xyz":
        columns[f"reference.marker_{axis}"] = np.zeros_like(t)
        columns[f"truth.marker_{axis}"] = error if axis == "x" else np.zeros_like(t)
    return window(t, columns)


def test_laps_are_judged_one_by_one():
    found = lap_errors(repeated([4e-5, 2e-5, 1e-5, 1e-5], ended=3))
    assert found.marker == pytest.approx([4e-5, 2e-5, 1e-5, 1e-5])
    assert found.wires == pytest.approx(np.array([4e-5, 2e-5, 1e-5, 1e-5]) / math.sqrt(2.0))
    assert found.ended == 3
    assert learning_gain([repeated([4e-5, 1e-5], ended=9)]) == pytest.approx(0.25)
    assert laps_learnt([repeated([4e-5, 1e-5], ended=9)]) == math.inf
    assert laps_learnt([repeated([4e-5, 1e-5, 1e-5], ended=2)]) == 2.0


def tense(segment):
    """Return a window of a run that energises for 1 s, approaches for 1 s, moves, is released."""
    t = np.arange(0.0, 5.0, 0.01)
    tension = np.full_like(t, 20.0)
    tension[t < 1.0] = 0.5  # no pressure yet
    tension[(t > 0.5) & (t < 0.6)] = 70.0
    tension[(t > 1.5) & (t < 1.6)] = 7.0  # while it approaches
    tension[t > 4.5] = 1.0  # released
    phase = np.select([t < 2.0, t < 4.0], [0.0, 1.0], 2.0)
    names = ("phase", "reference.time", *(f"truth.tension_{name}" for name in CHANNELS))
    columns = tuple(Column(name, "", "") for name in names)
    values = np.column_stack([phase, t - 2.0, *[tension] * 4])
    log = Log(columns, np.arange(len(t)), t, values, np.arange(len(t)), True)
    return [Window(Segment(segment, 0.0, 2.0), Samples(log), slice(0, 200))]


def test_wires_are_judged_from_the_moment_that_control_takes_over():
    assert tension_min(tense("all")) == 7.0
    assert tension_min(tense("0.5 Hz")) == 20.0


def test_no_wire_may_be_torn_even_while_it_is_energised():
    assert tension_max(tense("all")) == 70.0
    assert tension_max(tense("0.5 Hz")) == 20.0
