"""Measures of the arm on made-up logs, whose numbers are known."""

import math

import numpy as np
import pytest

from rig.hal.motion import Segment
from rig.mechanisms.arm.measures import ARM_MEASURES

PERIOD = 5e-3
LAG = 8e-3


class Part:
    """What a measure is given: columns over a segment."""

    def __init__(self, name, start, end, **columns):
        self.segment = Segment(name, start, end)
        every = np.arange(round(10.0 / PERIOD)) * PERIOD
        chosen = (every >= start) & (every < end)
        self.t = every[chosen]
        self._columns = {
            key.replace("__", "."): np.broadcast_to(values(self.t), self.t.shape)
            for key, values in columns.items()
        }

    def has(self, name):
        return name in self._columns

    def column(self, name):
        return self._columns[name]

    def columns(self, prefix):
        return np.column_stack([x for name, x in self._columns.items() if name.startswith(prefix)])


def measure(name, *parts):
    return ARM_MEASURES[name].compute(parts)


def elbow(t, lag=0.0):
    """Return S3 of an elbow that goes through 0 at 4 s and reaches |0.5| a second around it."""
    return -0.5 * (t - lag - 4.0)


def test_crossing_is_when_the_reading_was_taken():
    part = Part(
        "all", 0, 10, reading__index_elbow=lambda t: elbow(t, LAG), reading__age=lambda t: LAG
    )
    assert measure("time_crossing_measured", part) == pytest.approx(4.0, abs=1e-9)
    assert measure("elbow_sign_changes_measured", part) == 1.0


def test_elbow_that_turns_back_crosses_never():
    part = Part("all", 0, 10, reading__index_elbow=lambda t: 1e-3 + (t - 4.0) ** 2,
                reading__age=lambda t: LAG)  # fmt: skip
    assert measure("time_crossing_measured", part) == math.inf
    assert measure("elbow_sign_changes_measured", part) == 0.0


def test_dwell_lasts_from_border_to_border_whenever_the_arm_gets_there():
    columns = {"plan__index_elbow": elbow, "reading__index_elbow": lambda t: elbow(t, LAG)}
    parts = Part("all", 0, 10, **columns), Part("region", 3.0, 5.0, **columns)
    assert measure("dwell_time_measured", *parts) == pytest.approx(2.0, abs=1e-9)
    assert measure("dwell_time_measured", parts[0]) == math.inf, "a law without a region"


def hand(x):
    return {f"truth__hand_{axis}": (x if axis == "x" else lambda t: 0.0) for axis in "xyz"} | {
        f"reference__hand_{axis}": lambda t: 0.0 for axis in "xyz"
    }


def test_hand_has_arrived_once_it_stays_within_a_fifth_of_a_millimetre():
    settling = Part("all", 0, 10, **hand(lambda t: 1e-3 * np.exp(-(t - 2.0))))
    assert measure("time_end_measured", settling) == pytest.approx(2.0 + math.log(5.0), abs=PERIOD)
    never = Part("all", 0, 10, **hand(lambda t: 1e-3))
    assert measure("time_end_measured", never) == math.inf


def test_deviation_is_from_the_path_as_far_as_it_is_gone():
    path = {"plan__path_x": lambda t: t, "plan__path_y": lambda t: 0.0}
    path["plan__path_z"] = lambda t: 0.0
    late = {"truth__hand_x": lambda t: t - 0.01, "truth__hand_y": lambda t: 2e-3 * (t > 2.0)}
    part = Part("all", 1, 3, **path, **late, truth__hand_z=lambda t: 0.0)
    # Late on the path is on the path, but not before its beginning: there it is 10 mm away.
    assert measure("path_deviation_measured", part) == pytest.approx(0.01)
    later = Part("all", 1, 3, **path, truth__hand_x=lambda t: np.maximum(t - 0.01, 1.0),
                 truth__hand_y=late["truth__hand_y"], truth__hand_z=lambda t: 0.0)  # fmt: skip
    assert measure("path_deviation_measured", later) == pytest.approx(2e-3)


def test_rates_that_are_not_as_scaled_are_the_residual():
    axes = ("vx", "vy", "vz", "wx", "wy", "wz")
    columns = {f"plan__asked_{axis}": lambda t: 1.0 for axis in axes}
    columns |= {f"reading__twist_{a}": (lambda t, a=a: 0.5 if a[0] == "v" else 0.3) for a in axes}
    columns |= {"plan__scale": lambda t: 0.5, "plan__scale_turn": lambda t: 0.25}
    assert measure("twist_residual_measured", Part("path", 0, 1, **columns)) == pytest.approx(0.05)


def test_joints_a_whole_turn_on_are_back():
    def turned(t):
        return (2.0 * math.pi + 1e-3) * t / t[-1]

    columns = {f"reading__position_q{k}": turned for k in range(1, 7)}
    assert measure("return_error_measured", Part("all", 0, 1, **columns)) == pytest.approx(1e-3)
