"""One of the plants that gains are tried on has noisier encoders than the profile says."""

import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.assembly.simulated import lend_plant
from rig.config import find_configs, load_profile
from rig.tuning.workbench import Request, Workbench

AS_SHIPPED = ("calibration=false",)


def numbers_in(memory):
    """Yield every array of what a plant works on."""
    for one in memory:
        if isinstance(one, tuple):
            yield from numbers_in(one)
        else:
            yield np.asarray(one)


@pytest.mark.parametrize("rig", ["cylinder", "cylinder-valves", "joint"])
def test_a_noisier_plant_is_one_whose_profile_says_so(rig):
    told = Workbench(Request(rig, "cascade", None, AS_SHIPPED, None, 0)).ensemble.nominal.numbers

    def lent(*options, noisier=1.0):
        profile = load_profile(rig, REGISTRY, (*AS_SHIPPED, *options), find_configs())
        return list(numbers_in(lend_plant(profile, told, 3, noisier=noisier).memory))

    noisier, said, quiet = lent(noisier=4.0), lent("plant.encoder_noise=4 um"), lent()
    assert len(noisier) == len(said) == len(quiet)
    for one, other in zip(noisier, said, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not all(map(np.array_equal, noisier, quiet))


def test_setpoints_turn_round_for_it_in_a_trial():
    bench = Workbench(Request("cylinder", "cascade", None, AS_SHIPPED, None, 0))
    *_, noisy = bench.ensemble.corners()
    quiet, loud = (
        bench.trial({}, member, coarse=True).reversals for member in (bench.ensemble.nominal, noisy)
    )
    assert loud > quiet
