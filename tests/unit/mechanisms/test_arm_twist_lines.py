"""How far a hand is off twists: lines in the base's axes, screws in the tool's."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from controllers.arm.online import rehearsal
from controllers.arm.online.commands import TwistRows
from controllers.arm.types import AT_REST
from rig.mechanisms.arm.twist_lines import off_direction

GEOMETRY = ArmGeometry()
ARM = dimensions_of(GEOMETRY)
START = (0.2, 0.3, 1.5, 0.1, 0.9, -0.3)


def drawn(seed, frame):
    rng = np.random.default_rng((401, seed))
    v = rng.normal(size=3) * 10 ** rng.uniform(-2.5, -0.9)
    w = rng.normal(size=3) * rng.choice((0.0, 1e-7, 0.05, 0.3))
    rows = ((0.0, *v.tolist(), *w.tolist()), (1.5, *AT_REST))
    return TwistRows(rows=rows, frame=frame, start=START), np.concatenate((v, w))


def plan_of(twists, period=5e-3):
    return Esc(EscSettings(), GEOMETRY, period).prepare_twists(twists)


def poses_of(plan):
    poses = np.tile(np.eye(4), (len(plan.t), 1, 1))
    for k, q in enumerate(plan.positions.tolist()):
        made = forward(ARM, tuple(q))
        poses[k, :3, :3], poses[k, :3, 3] = made.rotation, made.position
    return poses


def screw_error(plan, twist, first, last):
    """Return how far poses are off the screw through the first, by matrix exponentials, m."""
    generator = np.zeros((4, 4))
    x, y, z = twist[3:]
    generator[:3, :3] = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))
    generator[:3, 3] = twist[:3]
    poses = poses_of(plan)[first:last]
    size = np.linalg.norm(twist[:3]) or 1.0
    worst = 0.0
    for k in range(0, len(poses), 7):
        seen = np.linalg.inv(poses[0]) @ poses[k]
        s = np.linalg.norm(seen[:3, 3]) / size
        best = min(
            np.linalg.norm(expm(generator * t)[:3, 3] - seen[:3, 3])
            for t in np.linspace(0.98 * s, 1.02 * s, 4001)
        )
        worst = max(worst, float(best))
    return worst


@pytest.mark.parametrize("seed", range(8))
def test_a_twist_in_the_tools_axes_is_followed_on_its_screw(seed):
    twists, twist = drawn(seed, "tool")
    plan = plan_of(twists)
    away, turned = off_direction(plan, GEOMETRY, twists)
    assert away < 1e-6
    assert turned < 1e-5
    first, last = int(0.6 / plan.period), int(1.4 / plan.period)
    # Its search goes in steps of 1e-5 of the way.
    assert screw_error(plan, twist, first, last) < 1e-6 + 1e-5 * np.linalg.norm(twist[:3])


def test_who_takes_the_tools_axes_as_they_are_when_a_period_begins_is_found_out(monkeypatch):
    ours = rehearsal.asked_in_base
    monkeypatch.setattr(rehearsal, "asked_in_base", lambda *a: ours(*a[:4]))
    twists = TwistRows(
        rows=((0.0, 0.08, 0.0, 0.05, 0.0, 0.4, 0.0), (1.5, *AT_REST)), frame="tool", start=START
    )
    plan = plan_of(twists)
    away, _ = off_direction(plan, GEOMETRY, twists)
    assert away > 1e-5
    whole = screw_error(plan, np.array((0.08, 0.0, 0.05, 0.0, 0.4, 0.0)), 100, 300)
    assert away == pytest.approx(whole, rel=0.3)


@pytest.mark.parametrize("seed", range(4))
def test_a_twist_in_the_bases_axes_is_a_line_with_a_turn_beside_it(seed):
    twists, _ = drawn(seed, "base")
    away, turned = off_direction(plan_of(twists), GEOMETRY, twists)
    assert away < 1e-7
    assert turned < 1e-5


def test_a_hand_beside_its_line_is_measured():
    """A plan of another twist than was asked for: the angle between them times the way."""
    rows = ((0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 0.0), (1.5, *AT_REST))
    plan = plan_of(TwistRows(rows=rows, start=START))
    lean = 0.01
    turn = Rotation.from_rotvec((0.0, 0.0, lean)).apply((0.0, 0.05, 0.0))
    plan.command[: int(1.5 / plan.period)] = (*turn, 0.0, 0.0, 0.0)
    asked = TwistRows(rows=rows, start=START)
    away, _ = off_direction(plan, GEOMETRY, asked)
    assert away == pytest.approx(np.sin(lean) * 0.05 * 1.0, rel=0.02)
