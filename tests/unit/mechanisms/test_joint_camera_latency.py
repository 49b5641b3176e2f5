"""A camera's lateness is found from drawn motions, whatever else parts camera and encoders."""

import math

import numpy as np
import pytest

from rig.experiment.ending import say_for_rig
from rig.mechanisms.joint.camera_latency import WRONG, fit_lateness, remark_on_latency

SEEDS = range(6)
T = 1e-3 * np.arange(12_000)
FRAME = 1.0 / 60.0
NAMES = ("clock", "reading.marker_age", "reading.marker_time", "reading.age")


def way(t, rng_values, speed=1.0):
    """Return a marker's way on its sphere, m, shape (n, 3)."""
    tilt, azimuth, phases = rng_values
    x = tilt * np.sin(math.tau * 0.31 * speed * t + phases[0])
    y = tilt * np.cos(math.tau * azimuth * speed * t + phases[1])
    return 52e-3 * np.column_stack([x, y, np.sqrt(1.0 - x * x - y * y)])


class Bench:
    """A joint that moves on a drawn way before a camera that is drawn beside its calibration."""

    def __init__(self, seed, late, speed=1.0):
        rng = np.random.default_rng([30, seed])
        drawn = rng.uniform(0.2, 0.5), rng.uniform(0.2, 0.6), rng.uniform(0.0, math.tau, 2)
        self.marker = way(T, drawn, speed)
        stamps = np.arange(0.05, T[-1] - 0.1, FRAME)
        exposed = stamps - late
        moved = way(exposed + 1e-4, drawn, speed) - way(exposed - 1e-4, drawn, speed)
        along = moved / np.maximum(np.linalg.norm(moved, axis=1), 1e-12)[:, None]
        seen = way(exposed, drawn, speed) - rng.uniform(0.0, 80e-6) * along
        turned = seen + np.cross(rng.uniform(-0.02, 0.02, 3), seen) + rng.uniform(-2e-3, 2e-3, 3)
        noise = rng.normal(0.0, 10e-6, turned.shape)
        kept = rng.uniform(size=len(stamps)) > 0.2
        self.stamps, self.seen = stamps[kept], (turned + noise)[kept]

    def found(self):
        return fit_lateness(T, self.marker, self.stamps, self.seen)

    def logged(self, name):
        """Return a column of the log that such a run leaves."""
        newest = np.searchsorted(self.stamps + 0.04, T, "right") - 1
        if name.startswith("estimate.encoder_marker_"):
            return self.marker[:, "xyz".index(name[-1])]
        if name in ("clock", "reading.age"):
            return T if name == "clock" else np.zeros(len(T))
        if name == "reading.marker_age":
            return np.where(newest < 0, -1.0, T - self.stamps[newest])
        if name == "reading.marker_time":
            return np.where(newest < 0, 0.0, self.stamps[newest])
        return np.where(newest < 0, 0.0, self.seen[newest, "xyz".index(name[-1])])


@pytest.mark.parametrize("seed", SEEDS)
def test_drawn_lateness_is_found_within_its_interval(seed):
    late = np.random.default_rng([31, seed]).uniform(-30e-3, 60e-3)
    found = Bench(seed, late).found()
    assert abs(found.late - late) < found.uncertain < 3e-3


@pytest.mark.parametrize("seed", SEEDS)
def test_a_camera_that_is_right_to_a_millisecond_is_not_spoken_of(seed):
    late = np.random.default_rng([32, seed]).uniform(-1e-3, 1e-3)
    assert remark_on_latency(Bench(seed, late).logged, "eye", 20e-3) == ()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_camera_that_is_wrong_by_just_more_than_is_permitted_is_spoken_of(seed):
    rng = np.random.default_rng([34, seed])
    late = math.copysign(WRONG + rng.uniform(0.05e-3, 1e-3), rng.uniform(-1.0, 1.0))
    (note,) = remark_on_latency(Bench(seed, late).logged, "eye", 20e-3)
    seen = float(note.message.partition("I see ")[2].partition(" ")[0])
    assert seen == pytest.approx(20.0 + late * 1e3, abs=1.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_wrong_is_said_with_what_the_profile_says(sign):
    late = sign * np.random.default_rng(33).uniform(6e-3, 15e-3)
    bench = Bench(7, late)
    (note,) = remark_on_latency(bench.logged, "eye", 20e-3)
    assert note.kind == "camera"
    assert note.message.startswith("eye: the profile says a latency of 20 ms, I see ")
    seen = float(note.message.partition("I see ")[2].partition(" ")[0])
    assert seen == pytest.approx(20.0 + late * 1e3, abs=1.0)
    (note,) = remark_on_latency(bench.logged, "eye", None)
    assert " older than their stamps say; " in note.message
    told = say_for_rig(note.message, "joint-fine")  # as a run says it
    assert told.endswith("; `rig calibrate joint-fine camera` measures it")


def test_a_joint_that_hardly_moves_tells_nothing():
    assert Bench(1, 20e-3, speed=1e-3).found() is None
    bench = Bench(1, 20e-3)
    bench.seen, bench.stamps = bench.seen[:100], bench.stamps[:100]
    assert bench.found() is None
