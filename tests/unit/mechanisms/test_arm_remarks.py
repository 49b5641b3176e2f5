"""What is said of an arm's plan that its drives cannot do, or that does not get to its end."""

import dataclasses
import re

import pytest

from controllers.arm.esc import EscPaper, EscPaperSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Line
from controllers.arm.plain import Inverse, InverseSettings
from controllers.arm.turn_path import TurnPath
from rig.mechanisms.arm.remarks import remarks_of_plan

GEOMETRY = ArmGeometry()
PAST_THE_WRIST = Line(middle=(0.3, 0.4, 1.3, 0.2, 0.004, 0.1), direction=(0.0, 1.0, 0.2))


def said(kind, settings, path):
    plan = kind(settings, GEOMETRY, 5e-3).prepare(path)
    notes = remarks_of_plan(plan, dimensions_of(GEOMETRY), GEOMETRY)
    return plan, dict(notes)


def test_the_joint_is_named_that_a_law_without_bounds_asks_for_most():
    plan, notes = said(Inverse, InverseSettings(), PAST_THE_WRIST)
    shares = plan.peak_rates / GEOMETRY.rate_limits
    assert shares.max() > 1.1
    rate = float(re.search(r"would need (\S+) rad/s of", notes["is too fast"])[1])
    assert notes["is too fast"].startswith(f"for q{shares.argmax() + 1}, ")
    assert rate == pytest.approx(plan.peak_rates[shares.argmax()], rel=1e-2)
    assert "ends early" not in notes


def test_nothing_is_said_of_a_law_that_keeps_its_rates_to_the_end():
    _, notes = said(LookAhead, LookAheadSettings(), PAST_THE_WRIST)
    assert not {"is too fast", "ends early"} & set(notes)


def test_a_plain_inverse_that_waits_at_a_stretched_arm_stalls():
    path = TurnPath((-0.6, 0.5, 0.0, 1.8, 1.3, -0.8), (-1.0, 0.0, 0.0), angle=0.04, rate=0.15)
    plan, notes = said(Inverse, InverseSettings(), path)
    assert plan.outcome == "stalls"
    assert notes["ends early"].startswith("inverse stalls after 0.267 s and 0 m, before the end")
    bent = dataclasses.replace(path, start=(-0.6, 0.5, 0.8, 1.8, 1.3, -0.8))
    assert "ends early" not in said(Inverse, InverseSettings(), bent)[1]


def test_the_papers_law_says_where_it_stays():
    path = Line(middle=(0.3, 0.4, 1.3, 0.0, 0.0, 0.1), direction=(0.3, 1.0, 0.2))
    plan, notes = said(EscPaper, EscPaperSettings(), path)
    assert plan.outcome == "stalls" and "esc-paper stalls after" in notes["ends early"]
