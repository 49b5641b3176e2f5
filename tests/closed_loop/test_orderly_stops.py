"""An orderly stop brakes to rest under control and releases from balance, at any instant."""

import random

import numpy as np
import pytest
from stop_bench import Stopped

from rig.assembly import Backend

DRAWN = random.Random(1741)
LIMIT = 20e-3
"""Of the cylinder's position, as its profile says, m."""
RELEASED = {"": 2e-3, "-low-speed": 0.5e-3}
"""By so much a pair moves while it is released, m: two regulators that are late do not vent alike,
and standard seals hold 75 kPa and then slip."""
STEEPEST = np.radians(60.0)
ROUND = np.radians(24.0)
"""Of a circle at 20 degrees whose seals stick and slip: the marker, 52 mm out, strays by 3 mm."""
SINE = ("reference.amplitude=10 mm", "reference.tones=[{frequency: 1 Hz, periods: 3}]")
CIRCLE = ("reference.tones=[{frequency: 0.5 Hz, laps: 1}]",)


def draw(count, kinds, first, last):
    """Return kinds, seeds and instants; one run reaches its end."""
    cases = [
        (DRAWN.choice(kinds), DRAWN.randrange(1000), DRAWN.uniform(first, last))
        for _ in range(count)
    ]
    return [*cases, (*cases[0][:2], None)]


@pytest.mark.parametrize(
    ("kind", "seed", "at"),
    draw(
        24,
        [
            (backend, seals, law)
            for backend in (Backend.SIM, Backend.VIRTUAL)
            for seals in ("", "-low-speed")
            for law in ("cascade", "pid-friction")
        ],
        -0.4,
        2.95,
    ),
)
def test_cylinder_stays_within_its_swing_wherever_it_is_stopped(kind, seed, at):
    backend, seals, law = kind
    options = (*SINE, f"simulation.seed={seed}", f"controller={law}")
    run = Stopped(f"cylinder-sine{seals}", options, backend, at)
    assert run.outcome.fault is None
    assert run.outcome.stopped == (at is not None)
    assert np.abs(run.column("position")).max() < LIMIT
    assert np.abs(run.during_stop("position")).max() < 11.5e-3
    assert np.ptp(run.released("position")) < RELEASED[seals]
    assert run.column("pressure_agonist")[-1] < 5e3
    assert run.column("pressure_antagonist")[-1] < 5e3


@pytest.mark.parametrize(
    ("kind", "seed", "at"), draw(6, [Backend.SIM, Backend.VIRTUAL], -0.4, 3.95)
)
def test_joint_stays_on_its_circle_wherever_it_is_stopped(kind, seed, at):
    run = Stopped("joint-circle", (*CIRCLE, f"simulation.seed={seed}"), kind, at)
    assert run.outcome.fault is None
    tilt = np.arccos(np.clip(run.column("axis_z"), -1.0, 1.0))
    assert tilt.max() < STEEPEST
    last = np.arccos(np.clip(run.during_stop("axis_z"), -1.0, 1.0))
    assert last.max() < ROUND
    assert np.ptp(np.arccos(np.clip(run.released("axis_z"), -1.0, 1.0))) < np.radians(0.5)
    for channel in (1, 2, 3, 4):
        assert run.column(f"pressure_ch{channel}")[-1] < 5e3
