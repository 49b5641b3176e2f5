"""Legs that feel: slopes that no plan knows, and sensors that lie; judged by the plant's truth."""

import numpy as np
import pytest
from legs_bench import BRISK, IN_MID_SWING, Walk, make_plan

from rig.assembly import Backend

FELT = ("rig=legs-balance", "law=sc-trapezoid", *BRISK)
BLIND = ("legs.stabiliser=null", "legs.sag=null")


def fault_in_swing(*fault, backend=Backend.SIM):
    plan = make_plan("legs-walk", *FELT)
    return Walk(plan, IN_MID_SWING, lambda world, _: broken(world).inject(*fault), backend=backend)


def broken(world):
    return getattr(world, "plant", world)  # an emulated rig has its plant, `sim` is one


def error_of_pressure(walk):
    """Return how far the feet are pressed from the plan in the last swing's second half, m."""
    felt, planned = (
        np.array([walk.column(f"{name}_{axis}")[-300:] for axis in "xy"])
        for name in ("balance.pressure", "plan.zero_moment")
    )
    return np.abs(np.median(felt - planned, axis=1))


@pytest.mark.parametrize("ground", ["ground_pitch=3 deg", "ground_roll=-3 deg"])
def test_the_pressure_is_brought_back_on_a_slope_and_the_feet_slip_less(ground):
    felt, blind = (
        Walk(make_plan("legs-walk", *FELT, f"plant.{ground}", *more), backend=Backend.SIM)
        for more in ((), BLIND)
    )
    for walk in (felt, blind):
        assert walk.outcome.fault is None
        assert walk.truth_after["truth.fell"] == 0.0
    assert max(error_of_pressure(felt)) < 0.5 * max(error_of_pressure(blind))
    slips = [max(w.column("truth.slip_right").max(), w.column("truth.slip_left").max())
             for w in (felt, blind)]  # fmt: skip
    assert slips[0] < slips[1]


def test_frozen_feet_end_the_walk_by_name_and_the_robot_stands():
    walk = fault_in_swing("feet_frozen", backend=Backend.VIRTUAL)
    assert "feet: its readings are frozen" in str(walk.outcome.fault)
    assert walk.detected_after <= 25  # 0.1 s, and the sensors' delay
    assert walk.truth_after["truth.fell"] == 0.0


@pytest.mark.parametrize(
    ("fault", "words"),
    [(("feet_offset", 20.0), "the feet bear"), (("gyro_offset", 0.5), "the waist turns")],
)
def test_what_cannot_be_true_lets_the_walk_go_on_as_planned(fault, words):
    walk = fault_in_swing(*fault)
    assert walk.outcome.fault is None
    assert words in walk.plan.controller.corrections.doubt
    assert walk.truth_after["truth.fell"] == 0.0


def test_a_stop_in_mid_walk_keeps_the_corrections():
    plan = make_plan("legs-walk", *FELT, "plant.ground_pitch=3 deg")
    walk = Walk(plan, IN_MID_SWING, lambda _, stop: stop.request(), backend=Backend.SIM)
    assert walk.outcome.fault is None
    assert walk.truth_after["truth.fell"] == 0.0
    applied = walk.joints("applied.position")[walk.happened - 5 :]
    assert np.abs(np.diff(applied, axis=0)).max() < 0.01  # no jump back to the plan


@pytest.mark.parametrize("seed", range(6))
def test_a_push_that_topples_the_robot_ends_its_walk(seed):
    rng = np.random.default_rng((0xFA11, seed))
    plan, at = make_plan("legs-walk", *FELT), rng.uniform(0.2, 2.5)
    side, way = rng.choice(["forward", "left"]), rng.choice([-1.0, 1.0])
    fault = (f"{side}.push", way * rng.uniform(2.5, 5.0))
    walk = Walk(plan, at, lambda world, _: world.inject(*fault), backend=Backend.SIM)
    assert walk.truth_after["truth.fell"] == 1.0
    assert "the robot falls, lies or is lifted" in str(walk.outcome.fault)
    fallen = np.flatnonzero(walk.column("truth.fell"))
    assert len(walk.column("truth.fell")) - fallen[0] < 200  # 1 s
