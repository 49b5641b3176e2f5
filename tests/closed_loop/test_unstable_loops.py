"""A loop that its regulators make unstable ends with its name, whatever drew the delay."""

import random

import numpy as np
import pytest
from stop_bench import Stopped

from rig.assembly import Backend

DRAWN = random.Random(2519)
BLIND = tuple(
    f"cylinder.alarms.pressure.{alarm}"
    for alarm in ("deviation=499 kPa", "slow=50", "offset=499 kPa")
)
"""The pressures' alarms would see such a regulator first: here the swing itself has to be seen."""


@pytest.mark.parametrize(
    ("dead", "seed", "law"),
    [
        (DRAWN.uniform(14e-3, 40e-3), DRAWN.randrange(1000), DRAWN.choice(["cascade", "pid"]))
        for _ in range(6)
    ],
)
def test_a_pair_that_swings_is_stopped_and_named_and_never_ends_as_ok(dead, seed, law):
    options = (
        *BLIND,
        f"plant.regulator.dead_time={dead} s",
        f"simulation.seed={seed}",
        f"controller={law}",
    )
    run = Stopped("cylinder-ideal-sine", options, Backend.SIM, None)
    assert run.outcome.fault is not None
    assert "the pair oscillates at" in str(run.outcome.fault), run.outcome.fault
    assert np.abs(run.column("position")).max() < 23e-3
