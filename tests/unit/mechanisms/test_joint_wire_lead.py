"""What three rods say of the fourth, in detail."""

import math

import numpy as np
import pytest
from joint_fakes import BASE, WireBench, off, rods_at

TILTED = rods_at(0.3, 0.4)


# What is looked at leaves no trace ---------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_what_was_looked_at_before_changes_nothing(seed):
    """To the last bit: a search that began elsewhere would end elsewhere."""
    rng = np.random.default_rng(seed)
    places = [off(rods_at(rng.uniform(0.1, 0.9), rng.uniform(0.0, 6.0)), 1, 1e-3) for _ in range(4)]
    fresh = [
        (WireBench().watch.axis_of(place), WireBench().watch._residual_of(place),
         WireBench().watch._without(place, 2))
        for place in places
    ]  # fmt: skip
    watch = WireBench().watch
    for ask in range(3):
        for place, before in zip(places, fresh, strict=True):
            asks = (watch.axis_of, watch._residual_of, lambda rods: watch._without(rods, 2))
            assert asks[ask](place) == before[ask]


def test_three_rods_have_their_pose_in_a_few_rounds(monkeypatch):
    watch = WireBench().watch
    solve, tried = watch._diagnosis.update, []
    monkeypatch.setattr(watch._diagnosis, "update", lambda rods: tried.append(rods) or solve(rods))
    watch._without(off(TILTED, 1, 2e-3), 0)
    assert 2 < len(tried) < 20


def test_the_rest_is_of_three_rods():
    """Also where the fourth has not come to rest."""
    watch = WireBench().watch
    solve, found = watch._diagnosis.update, []
    watch._diagnosis.update = lambda rods: found.append(solve(rods)) or found[-1]
    left, _ = watch._without(off(rods_at(0.79, 0.5 * math.pi), 1, 14e-3), 1)
    residuals = np.array(found[-1].residuals)
    assert abs(residuals[1]) > 1e-6
    assert left == pytest.approx(math.sqrt(0.5 * np.sum(np.delete(residuals, 1) ** 2)), rel=1e-12)


def test_the_ends_of_a_cylinder_and_the_speed_of_rest_belong_to_them():
    end = "the wire of ch1 is cut or has come off: its rod is at its end"
    for home, stroke, rod in ((1e-3, 0.06, 0.0), (2.0 - 1e-3, 2.0, 0.0)):
        bench = WireBench(residual=math.inf)
        bench.watch._limits = bench.watch._limits._replace(home=home, stroke=stroke)
        for was in (-1e-3, 0.0):
            bench.check((was, 0.0, 0.0, 0.0))
        assert bench.watch._explain_wire(0, 2e-3, rod, BASE) == end


@pytest.mark.parametrize("moved", [0.0, 0.999e-3])
def test_a_rod_that_nobody_saw_run_to_its_end_may_be_at_home_and_its_encoder_wrong(moved):
    bench = WireBench(residual=math.inf)
    bench.watch._limits = bench.watch._limits._replace(home=0.5e-3)
    for was in (-moved, 0.0):
        bench.check((was, 0.0, 0.0, 0.0))
    said = bench.watch._explain_wire(0, 2e-3, 0.0, BASE)
    assert said.endswith(f"at its end, or {bench.watch._encoders[0]} is wrong: it has not moved")


def test_a_rod_that_moves_slower_than_this_is_at_rest():
    bench = WireBench(residual=math.inf)
    for rod in (0.0, 0.05 * bench.STEP):
        bench.check((rod, 0.0, 0.0, 0.0))
    assert "has slipped" in bench.watch._explain_wire(0, 2e-3, 0.0, BASE)
