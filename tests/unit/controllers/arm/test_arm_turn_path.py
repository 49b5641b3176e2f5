"""Turns about an axis: circles by centre and normal, and the tool about its own point."""

import numpy as np
import pytest
from arm_cases import GEOMETRIES, radians
from scipy.spatial.transform import Rotation as Turn
from twist_oracle import hand_of

from controllers.arm.esc import Esc, EscPaper, EscPaperSettings
from controllers.arm.look_ahead import LookAhead
from controllers.arm.plain import Inverse, InverseSettings
from controllers.arm.turn_path import TurnPath
from controllers.motion import InfeasibleMotion

START = radians(10, 20, 90, 20, 30, 0)
GEOMETRY = GEOMETRIES["paper"]


def planned(path, law=LookAhead, settings=None):
    return law(settings or law.Settings(), GEOMETRY, 5e-3).prepare(path)


@pytest.mark.parametrize("law", [LookAhead, Esc])
@pytest.mark.parametrize("seed", range(6))
def test_the_tool_turns_about_its_own_point(seed, law):
    axis = np.random.default_rng(seed).normal(size=3)
    plan = planned(TurnPath(START, tuple(axis), angle=0.4), law)
    p0, r0 = hand_of(GEOMETRY, START)
    p1, r1 = hand_of(GEOMETRY, plan.positions[-1])
    hands = np.array([hand_of(GEOMETRY, q)[0] for q in plan.positions])
    assert np.abs(hands - p0).max() < 1e-8
    wanted = Turn.from_rotvec(0.4 * axis / np.linalg.norm(axis)) * r0
    assert (r1 * wanted.inv()).magnitude() < 1e-8
    assert np.abs(p1 - p0).max() < 1e-8


@pytest.mark.parametrize("tool_turns", [True, False])
def test_a_circle_by_centre_and_normal(tool_turns):
    p0, r0 = hand_of(GEOMETRY, START)
    normal = np.array([0.2, -0.1, 1.0])
    centre = p0 - np.array([0.1, 0.02, 0.0]) + 0.3 * normal  # anywhere on the axis
    plan = planned(
        TurnPath(START, tuple(normal), tuple(centre), angle=2.0, rate=0.5, tool_turns=tool_turns)
    )
    unit = normal / np.linalg.norm(normal)
    out = p0 - centre - ((p0 - centre) @ unit) * unit
    hands = np.array([hand_of(GEOMETRY, q)[0] for q in plan.positions])
    away = hands - (p0 - out)
    assert np.abs(away @ unit).max() < 1e-7
    assert np.abs(np.linalg.norm(away, axis=1) - np.linalg.norm(out)).max() < 1e-7
    turn = Turn.from_rotvec(2.0 * unit)
    assert np.abs(away[-1] - turn.apply(out)).max() < 1e-7
    _, r1 = hand_of(GEOMETRY, plan.positions[-1])
    assert (r1 * ((turn * r0) if tool_turns else r0).inv()).magnitude() < 1e-7


def test_plain_laws_follow_it_too():
    plan = planned(TurnPath(START, (0, 1, 0), angle=0.3), Inverse, InverseSettings())
    _, r0 = hand_of(GEOMETRY, START)
    _, r1 = hand_of(GEOMETRY, plan.positions[-1])
    assert (r1 * r0.inv()).magnitude() == pytest.approx(0.3, abs=1e-4)


def test_what_cannot_be_is_said():
    with pytest.raises(ValueError, match="nothing turns"):
        TurnPath(START, (0, 0, 1), tool_turns=False)
    with pytest.raises(ValueError, match="axis must have a length"):
        planned(TurnPath(START, (0, 0, 0)))
    with pytest.raises(InfeasibleMotion, match=r"plans lines and circles .*, and not a turn;"):
        planned(TurnPath(START, (0, 0, 1)), EscPaper, EscPaperSettings())
    hand, _ = hand_of(GEOMETRY, START)
    far = tuple(np.add(hand, (0.0, 0.0, 2.0)))
    with pytest.raises(InfeasibleMotion, match="m the path leaves the workspace"):
        planned(TurnPath(START, (0, 1, 0), far))
