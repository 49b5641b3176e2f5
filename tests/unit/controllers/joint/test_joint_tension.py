"""Tensions that hold a pose, against equilibrium written out and linear programming."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from joint_axes import around, axes

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import (
    axis_from_tilt,
    natural_rotation,
    paper_rotation,
    rotate,
)
from controllers.spherical_joint.taut import (
    SlackWire,
    kept_taut,
    kept_within,
    pair_forces,
    raised,
)
from controllers.spherical_joint.tension import TensionDistribution

GEOMETRY = SphericalJointGeometry()
WIRES = ExactWires(GEOMETRY)
TENSIONS = TensionDistribution(GEOMETRY)


def torque_of(rotation, tensions):
    """Return the wires' torque on the ring: anchor x pull, summed."""
    return sum(
        tension * np.cross(rotate(rotation, anchor), direction)
        for tension, anchor, direction in zip(
            tensions, GEOMETRY.anchors, WIRES.directions(rotation), strict=True
        )
    )


@given(axes(most=70.0))
@example(axis_from_tilt(0.5, 6e-8))
@example(axis_from_tilt(4e-4, math.pi))
@example(axis_from_tilt(9e-4, -0.5 * math.pi))
def test_shares_turn_the_ring_nowhere(axis):
    rotation = natural_rotation(axis)
    shares = TENSIONS.shares(rotation)
    assert sum(shares) == pytest.approx(1.0)
    assert min(shares) > 0.0
    across = torque_of(rotation, shares) @ np.array(rotation)
    assert across[:2] == pytest.approx(0.0, abs=1e-10)
    # Where the ring tilts towards a wire the shares are those that spin a ring beside nowhere.
    assert across[2] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("tilt", "least"), [(0, 0.25), (20, 0.206), (40, 0.145), (60, 0.073), (70, 0.027)]
)
def test_smallest_share_round_a_circle(tilt, least):
    found = min(min(TENSIONS.shares(natural_rotation(axis))) for axis in around(tilt))
    assert found == pytest.approx(least, abs=6e-4)


@pytest.mark.parametrize("tilt", [0.0, 1e-7, 1e-4, 0.1, 0.35, 1.0])
def test_shares_do_not_jump_where_they_are_not_unique(tilt):
    on = TENSIONS.shares(natural_rotation(axis_from_tilt(tilt, 0.0)))
    beside = TENSIONS.shares(natural_rotation(axis_from_tilt(tilt, 2e-3)))
    assert on == pytest.approx(beside, abs=3e-3)


def test_no_tensions_hold_the_papers_poses_off_the_axes():
    """All four wires untwist the same way: some would have to push."""
    rotation = paper_rotation(axis_from_tilt(math.radians(20.0), math.radians(45.0)))
    assert min(TENSIONS.shares(rotation)) < -1.0
    with pytest.raises(SlackWire, match=r"wire \d would have to push"):
        TENSIONS.hold(rotation, 5.0)


@given(
    axes(most=70.0),
    st.floats(1.0, 20.0),
    st.floats(0.0, 150.0),
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)),
)
def test_hold_balances_a_load_with_every_wire_taut(axis, least, total, load):
    rotation = natural_rotation(axis)
    torque = rotate(rotation, (load[0], load[1], 0.0))
    tensions = TENSIONS.hold(rotation, least, total, torque)
    assert min(tensions) >= least - 1e-9
    assert sum(tensions) >= total - 1e-9
    assert min(tensions) == pytest.approx(least) or sum(tensions) == pytest.approx(total)
    left = torque_of(rotation, tensions) + np.array(torque)
    across = np.array(rotation).T @ left
    assert across[:2] == pytest.approx(0.0, abs=1e-9 * sum(tensions))


def test_hold_takes_no_more_than_linear_programming():
    from scipy.optimize import linprog

    for axis in [axis_from_tilt(0.9, 0.1 + 0.7 * k) for k in range(9)]:
        rotation = natural_rotation(axis)
        rows = np.array(WIRES.jacobian(rotation)).T
        best = linprog(np.ones(4), A_eq=rows, b_eq=np.zeros(3), bounds=[(7.0, None)] * 4)
        assert sum(TENSIONS.hold(rotation, 7.0)) == pytest.approx(best.fun, rel=1e-6)


@pytest.mark.parametrize(("ring", "closed"), [(18.0, 65), (20.0, 75), (22.0, 88), (23.5, 79)])
def test_force_closure_ends_at(ring, closed):
    """In degrees of tilt at the worst azimuth, to the degree above."""
    tensions = TensionDistribution(replace(GEOMETRY, ring_radius=ring * 1e-3))

    def holds(tilt):
        return all(min(tensions.shares(natural_rotation(axis))) > 0 for axis in around(tilt, 3))

    assert holds(closed - 1.2)
    assert not holds(closed + 0.2)


@pytest.mark.parametrize(("ring", "seated"), [(20.0, 73.9), (23.5, 73.4)])
def test_ring_stays_seated_up_to(ring, seated):
    geometry = replace(GEOMETRY, ring_radius=ring * 1e-3)
    tensions = TensionDistribution(geometry)

    def sits(tilt):
        for axis in around(tilt, 3):
            rotation = natural_rotation(axis)
            shares = tensions.shares(rotation)
            if min(shares) <= 0.0 or tensions.seating_margin(rotation, shares) <= 0.0:
                return False
        return True

    assert sits(seated)
    assert not sits(seated + 0.3)


@given(axes(most=85.0), st.lists(st.floats(1.0, 40.0), min_size=4, max_size=4))
def test_ring_sits_where_contacts_that_only_push_balance_the_wires(axis, tensions):
    from scipy.optimize import nnls

    geometry = replace(GEOMETRY, ring_radius=23.5e-3)
    wires, distribution = ExactWires(geometry), TensionDistribution(geometry)
    rotation = natural_rotation(axis)
    pull = np.array(tensions) @ np.array(wires.directions(rotation))
    lean, turn = geometry.ring_half_angle, np.linspace(0.0, 2 * np.pi, 361)
    circle = [np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean) + 0 * turn]
    _, missing = nnls(np.array(rotation) @ np.array(circle), -pull)
    margin = distribution.seating_margin(rotation, tuple(tensions))
    if abs(margin) > 1e-3:
        assert (missing < 1e-6 * np.linalg.norm(pull)) == (margin > 0.0)


@given(axes(most=65.0), st.lists(st.floats(0.0, 60.0), min_size=4, max_size=4))
def test_pair_forces_tilt_the_ring_as_the_tensions_do(axis, tensions):
    rotation = natural_rotation(axis)
    pose = TENSIONS.at(rotation)
    first, second = pair_forces(pose.first, pose.second, tuple(tensions))
    alone = (0.5 * first, -0.5 * second, -0.5 * first, 0.5 * second)
    left = (torque_of(rotation, tensions) - torque_of(rotation, alone)) @ np.array(rotation)
    assert left[:2] == pytest.approx(0.0, abs=1e-9)
    # Virtual work: a pair's force times its motion, half the difference of its shortenings.
    assert pair_forces(pose.first, pose.second, pose.shares) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_pairs_are_on_their_own_at_home():
    pose = TENSIONS.at(natural_rotation((0.0, 0.0, 1.0)))
    assert pose.first == pytest.approx((1.0, 0.0, -1.0, 0.0), abs=1e-12)
    assert pose.second == pytest.approx((0.0, -1.0, 0.0, 1.0), abs=1e-12)


@given(axes(most=65.0), st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)))
def test_tensions_are_kept_taut_without_tilting_the_ring(axis, forces):
    pose = TENSIONS.at(natural_rotation(axis))
    first, second = 0.5 * forces[0], 0.5 * forces[1]
    hold = raised(tuple(80.0 * share for share in pose.shares), pose.shares, 10.0)
    spread = (first, -second, -first, second)
    tensions = tuple(a + b for a, b in zip(hold, spread, strict=True))
    taut = pose.kept_taut(tensions, 10.0)
    assert min(taut) > 10.0 - 2e-3
    assert pair_forces(pose.first, pose.second, taut) == pytest.approx(forces, abs=1e-6)
    if min(tensions) >= 10.0:
        assert taut == tensions
    else:
        # Never more than it takes with only the pair's own two wires.
        assert sum(taut) < sum(tensions) + 8.0 * (10.0 - min(tensions)) + 0.05


def drawn_overload(rng, least, most):
    """Return a pose at 45 to 65 degrees, and tensions that one of its wires cannot bear."""
    while True:
        axis = axis_from_tilt(math.radians(rng.uniform(45.0, 65.0)), rng.uniform(-3.2, 3.2))
        pose = TENSIONS.at(natural_rotation(axis))
        hold = raised(tuple(145.0 * share for share in pose.shares), pose.shares, least)
        first, second = rng.uniform(-50.0, 50.0, 2)
        wanted = (hold[0] + first, hold[1] - second, hold[2] - first, hold[3] + second)
        taut = kept_taut(pose.first, pose.second, wanted, least)
        if max(taut) > most:
            return pose, taut


@pytest.mark.parametrize("seed", range(60))
def test_a_wire_at_its_greatest_tension_is_relieved_by_the_other_pair(seed):
    """As far as linear programming can, if its opposite wire keeps what it has."""
    from scipy.optimize import linprog

    least, most = 11.0, 85.0
    pose, taut = drawn_overload(np.random.default_rng(seed), least, most)
    forces = pair_forces(pose.first, pose.second, taut)
    found = kept_within(pose.first, pose.second, taut, least, most)
    assert pair_forces(pose.first, pose.second, found) == pytest.approx(forces, abs=1e-9)
    assert min(found) > least - 1e-9
    high = taut.index(max(taut))
    bounds = [(least, max(most, tension)) for tension in taut]
    bounds[high], bounds[(high + 2) % 4] = (0.0, None), (taut[(high + 2) % 4],) * 2
    goal = [float(k == high) for k in range(4)]
    best = linprog(goal, A_eq=[pose.first, pose.second], b_eq=forces, bounds=bounds)
    assert best.status == 0
    other = [(high + 1) % 4, (high + 3) % 4]
    gained = taut[high] - best.fun
    if gained < 0.5 * abs(0.5 * sum(best.x[k] - taut[k] for k in other)):
        assert found == taut  # the other pair would give way for little
    else:
        assert found[high] == pytest.approx(max(best.fun, most), abs=1e-6)


def test_near_home_the_other_pair_is_left_alone():
    pose = TENSIONS.at(natural_rotation(axis_from_tilt(math.radians(30.0), 2.5)))
    over = (12.0, 30.0, 95.0, 50.0)
    assert kept_within(pose.first, pose.second, over, 11.0, 85.0) == over


def test_tensions_that_the_wires_bear_stay_as_they_are():
    pose = TENSIONS.at(natural_rotation(axis_from_tilt(math.radians(60.0), 2.5)))
    borne = (12.0, 30.0, 85.0, 50.0)
    assert kept_within(pose.first, pose.second, borne, 11.0, 85.0) == borne


def test_keeping_a_wire_taut_at_a_great_tilt_takes_a_newton_for_a_newton():
    """Raising all tensions together would take 14 for one: that wire's share is 0.07."""
    pose = TENSIONS.at(natural_rotation(axis_from_tilt(math.radians(60.0), 0.0)))
    hold = raised(tuple(80.0 * share for share in pose.shares), pose.shares, 10.0)
    slack = (hold[0], hold[1] + 2.0, hold[2], hold[3] - 2.0)
    assert sum(pose.kept_taut(slack, 10.0)) < sum(slack) + 5.0
    assert sum(raised(slack, pose.shares, 10.0)) > sum(slack) + 25.0


def test_measured_anchors_share_tensions_as_exact_ones_do():
    """Anchors off by a third of a degree: no wire has to push where the ring leans to one."""
    quarter = 0.5 * math.pi
    skewed = SphericalJointGeometry(
        anchor_angles=tuple(
            quarter * (k + 1) + off for k, off in enumerate((3e-3, -3e-3, -5e-3, 5e-3))
        )
    )
    exact, measured = TensionDistribution(SphericalJointGeometry()), TensionDistribution(skewed)
    wires = ExactWires(skewed)
    for tilt in (1e-3, 0.2, 0.6):
        for azimuth in (0.0, 1e-3, 0.7, quarter):
            rotation = natural_rotation(
                (
                    math.sin(tilt) * math.cos(azimuth),
                    math.sin(tilt) * math.sin(azimuth),
                    math.cos(tilt),
                )
            )
            shares = measured.shares(rotation)
            assert sum(shares) == pytest.approx(1.0)
            assert shares == pytest.approx(exact.shares(rotation), abs=0.01)
            pose = measured.at(rotation)
            forces = pair_forces(pose.first, pose.second, shares)
            assert forces == pytest.approx((0.0, 0.0), abs=1e-9)
            torque = [
                sum(
                    share * row[axis]
                    for share, row in zip(shares, wires.jacobian(rotation), strict=True)
                )
                for axis in range(3)
            ]
            assert math.hypot(*torque) < 1e-3 * skewed.ball_radius
