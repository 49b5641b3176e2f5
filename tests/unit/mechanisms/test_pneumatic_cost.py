"""What a motion costs is counted as it is defined, on signals whose costs are known."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rig.experiment.measure import Samples, Window, apart
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.mechanisms.pneumatic.cost import JOINT_COSTS, PAIR_COSTS, turning_points
from rig.runtime.log import Log, LogError

PERIOD = 1e-3
SEEDS = range(5)
AREA, VOLUME = 1.8e-4, 1.2e-5
CONSTANTS = {"area": AREA, "volume_one": VOLUME, "volume_two": VOLUME}


def make_windows(columns, *segments, constants=CONSTANTS):
    count = len(next(iter(columns.values())))
    t = PERIOD * np.arange(count)
    columns = {"reference.time": t, "phase": np.ones(count), **columns}
    log = Log(
        tuple(Column(name, "1", "") for name in columns), np.arange(count, dtype=np.uint64), t,
        np.column_stack(list(columns.values())), np.arange(count, dtype=np.uint64), complete=True,
    )  # fmt: skip
    samples = Samples(log, constants)
    parts = segments or ((0.0, count * PERIOD),)
    return [
        Window(Segment(str(part), *part), samples, slice(*np.searchsorted(t, part)))
        for part in parts
    ]


def waves(frequency, amplitude, seconds, mean=2e5):
    return mean + amplitude * np.sin(math.tau * frequency * PERIOD * np.arange(seconds * 1000))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wave_turns_round_twice_a_period_if_it_swings_by_more_than_25_kpa(seed):
    rng = np.random.default_rng([1, seed])
    frequency, amplitude = int(rng.integers(2, 60)), rng.uniform(13e3, 200e3)
    still = np.full(10_000, 1e5)
    setpoints = {"applied.one": waves(frequency, amplitude, 10), "applied.two": still}
    windows = make_windows(setpoints)
    assert PAIR_COSTS["valve_reversals"].compute(windows) == pytest.approx(2 * frequency, abs=0.2)
    assert PAIR_COSTS["setpoint_range"].compute(windows) == pytest.approx(2 * amplitude, rel=0.02)
    rate = 4 * frequency * amplitude
    assert PAIR_COSTS["setpoint_rate"].compute(windows) == pytest.approx(rate, rel=0.03)
    small = make_windows({**setpoints, "applied.one": waves(frequency, 12.4e3, 10)})
    assert PAIR_COSTS["valve_reversals"].compute(small) == 0.0


@pytest.mark.parametrize("seed", SEEDS)
def test_noise_adds_no_turns_to_those_of_a_drawn_way(seed):
    rng = np.random.default_rng([2, seed])
    corners = np.cumsum(rng.uniform(60e3, 200e3, 12) * np.resize([1.0, -1.0], 12))
    way = np.concatenate([np.linspace(a, b, 100, endpoint=False) for a, b in pairwise(corners)])
    noisy = way + rng.uniform(-10e3, 10e3, len(way))
    assert len(list(turning_points(noisy, 25e3))) == len(corners)
    assert list(turning_points(way, 25e3))[1:-1] == pytest.approx(corners[1:-1])


def test_what_never_goes_far_has_no_turning_points():
    assert list(turning_points(np.array([1.0, 1.5, 0.8, 1.2]), 1.0)) == []
    assert list(turning_points(np.array([3.0]), 1.0)) == []


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("costs, sense", [(PAIR_COSTS, -1.0), (JOINT_COSTS, 1.0)])
def test_a_chamber_that_fills_while_its_piston_moves_takes_the_air_that_then_is_in_it(
    costs, sense, seed
):
    """One that moves at a constant pressure is filled by what it grows by."""
    rng = np.random.default_rng([3, seed])
    pressure, way = rng.uniform(50e3, 400e3), rng.uniform(5e-3, 25e-3)
    there_and_back = np.concatenate([np.linspace(0.0, way, 1000), np.linspace(way, 0.0, 1000)])
    noise = 250.0 * rng.standard_normal(2000)
    name = "position" if sense < 0 else "rod"
    windows = make_windows(
        {
            "reading.pressure_one": pressure + noise,
            "reading.pressure_two": np.full(2000, pressure),
            f"reading.{name}_one": there_and_back,
            f"reading.{name}_two": np.zeros(2000),
        }
    )
    normal = AREA * way * (pressure + 101_325.0) / 101_325.0
    assert costs["air_used"].compute(windows) == pytest.approx(normal / 1.999, rel=0.02)


def test_a_monitor_that_is_only_noisy_takes_no_air():
    rng = np.random.default_rng(4)
    noise = 120e3 + 250.0 * rng.standard_normal((2, 20_000))
    windows = make_windows(
        {
            "reading.pressure_one": noise[0],
            "reading.pressure_two": noise[1],
            "reading.position_one": np.zeros(20_000),
            "reading.position_two": np.zeros(20_000),
        }
    )
    assert PAIR_COSTS["air_used"].compute(windows) == 0.0


def test_each_instant_counts_once_however_windows_overlap():
    setpoints = {"applied.one": waves(20, 50e3, 10), "applied.two": np.zeros(10_000)}
    parts = make_windows(setpoints, (0.0, 4.0), (3.0, 5.0), (7.0, 9.0))
    spans = [(round(w.t[0], 3), round(w.t[-1], 3)) for w in apart(parts)]
    assert spans == [(0.0, 4.999), (7.0, 8.999)]
    assert PAIR_COSTS["valve_reversals"].compute(parts) == pytest.approx(40.0, abs=0.5)


def test_air_of_a_rig_whose_chambers_nobody_knows_is_refused():
    columns = dict.fromkeys(("reading.pressure_one", "reading.position_one"), np.zeros(2000))
    with pytest.raises(LogError, match="does not say what volume_one the rig has"):
        PAIR_COSTS["air_used"].compute(make_windows(columns, constants={"area": AREA}))
