"""An encoder that scatters is named, and not what its samples make of the rest of the rig."""

import numpy as np
import pytest
from cylinder_rods import CHANGE, NAMES
from cylinder_rods import Rods as PairRods

from rig.hal import LimitExceeded, SafetyError
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm


def shake(rods, sizes, cycles=64):
    """Have encoders scatter about a pair that stands."""
    chance = np.random.default_rng(5)
    for _ in range(cycles):
        rods.cycle(*(float(size * chance.normal()) for size in sizes))


@pytest.mark.parametrize("noisy", [0, 1])
def test_a_pull_that_nobody_sees_is_the_scatter_of_an_encoder(noisy, monkeypatch):
    rods = PairRods()
    rods.settle()
    sizes = [0.0, 0.0]
    sizes[noisy] = 60e-6
    shake(rods, sizes)
    monkeypatch.setattr(rods.watch._balance, "explain_unseen", lambda: "the carriage is pushed")
    with pytest.raises(SafetyError) as caught:
        shake(rods, sizes, 1)
    said = str(caught.value)
    assert said.startswith(f"{NAMES[noisy]} scatters by 0.0")
    assert said.endswith(" mm, which shakes setpoints (the carriage is pushed)")


@pytest.mark.parametrize("noisy", [0, 1])
def test_beside_an_encoder_that_scatters_the_other_one_is_not_frozen(noisy):
    for rods, kind in (
        (PairRods(change=CHANGE), LimitExceeded),
        (PairRods(frozen=FrozenAlarm(0.1e-3, 0.02)), SafetyError),
    ):
        rods.settle()
        sizes = [0.0, 0.0]
        sizes[noisy] = 20e-6
        shake(rods, sizes)  # it begins below either bound
        sizes[noisy] = 0.8 * CHANGE  # half of it is what the rods differ by
        with pytest.raises(kind, match=rf"{NAMES[noisy]} scatters by 0\.\d+ mm") as caught:
            shake(rods, sizes, 4000)
        assert f"{NAMES[1 - noisy]} is frozen" not in str(caught.value).partition("; or")[0]
