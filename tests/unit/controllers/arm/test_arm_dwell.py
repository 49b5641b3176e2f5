"""Dwelling at the boundary: the paper's Fig. 6 as numbers, and a profile that never stops."""

import math

import numpy as np
import pytest
from arm_cases import radians
from scipy.integrate import quad

from controllers.arm.dwell import (
    QuinticDwell,
    RampDwell,
    Switch,
    elbow_at_depth,
    integral_exact,
    integral_taylor,
    longest_quintic,
    switch_of,
)
from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import DwellLine
from controllers.motion import InfeasibleMotion

ARM = dimensions_of(ArmGeometry())
Q_S = elbow_at_depth(ARM, 0.03)
SWITCH = Switch(0.724365, 0.647329)


def paper(path, period=1e-2, **settings):
    return EscPaper(EscPaperSettings(**settings), ArmGeometry(), period).prepare(path)


def stay(plan):
    entered, left = plan.marks["region"]
    return left - entered


def test_the_region_and_its_integrals():
    assert math.degrees(Q_S) == pytest.approx(31.683594, abs=1e-6)
    reach = math.sqrt(ARM.a2**2 + ARM.a3**2 + 2 * ARM.a2 * ARM.a3 * math.cos(Q_S))
    assert reach == pytest.approx(0.76, abs=1e-15)
    assert integral_taylor(ARM, Q_S) == pytest.approx(1.418434278, abs=1e-9)
    assert integral_exact(ARM, Q_S) == pytest.approx(1.418139902, abs=1e-9)


@pytest.mark.parametrize(
    ("a2", "a3", "depth"), [(0.4, 0.39, 0.03), (0.3, 0.45, 0.12), (0.4, 0.4, 0.05)]
)
def test_integrals_against_quadrature(a2, a3, depth):
    arm = dimensions_of(ArmGeometry(a2=a2, a3=a3))
    q_s = elbow_at_depth(arm, depth)
    whole, _ = quad(
        lambda q: 2.0 / math.sqrt(a2 * a2 + a3 * a3 + 2 * a2 * a3 * math.cos(q)), 0, q_s
    )
    cut, _ = quad(lambda q: 2.0 / math.sqrt((a2 + a3) ** 2 - a2 * a3 * q * q), 0, q_s)
    assert integral_exact(arm, q_s) == pytest.approx(whole, rel=1e-13)
    assert integral_taylor(arm, q_s) == pytest.approx(cut, rel=1e-13)


def test_the_switch_values_of_figure_6():
    plan = paper(DwellLine())
    entered = plan.marks["region"][0]
    assert entered == pytest.approx(3.405916, abs=1e-6)
    v = 0.06
    wrist = np.array((0.5474, 0.0965, 0.0557))
    assert np.linalg.norm(wrist + v * entered * np.eye(3)[0]) == pytest.approx(0.76, abs=1e-4)
    cosine = (wrist[0] + v * entered) / 0.76
    switch = switch_of(ARM, Q_S, v, cosine)
    assert switch.b == pytest.approx(0.724365, abs=1e-4)
    assert switch.rate == pytest.approx(0.647329, abs=1e-3)


def test_the_longest_quintic():
    exact = integral_exact(ARM, Q_S)
    assert longest_quintic(exact, SWITCH) == pytest.approx(3.43990, abs=1e-4)
    assert longest_quintic(exact, Switch(SWITCH.b, 0.0)) == pytest.approx(4.19522, abs=1e-4)
    fast = Switch(10 * SWITCH.b, 100 * SWITCH.rate)
    assert longest_quintic(exact, fast) == pytest.approx(0.34399, abs=1e-5)
    at_limit = QuinticDwell(exact, longest_quintic(exact, SWITCH), SWITCH)
    assert at_limit.middle == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("switch", "least"),
    [(SWITCH, -0.1308), (Switch(SWITCH.b, 0.0), 0.0311), (Switch(7.243648, 64.73294), -21.86)],
)
def test_the_quintic_meets_its_integral_and_its_ends(switch, least):
    integral = integral_exact(ARM, Q_S)
    dwell = QuinticDwell(integral, 4.0, switch)
    h = 1e-6
    assert quad(dwell.at, 0.0, 4.0)[0] == pytest.approx(integral, abs=1e-12)
    assert dwell.at(0.0) == pytest.approx(switch.b) == dwell.at(4.0)
    assert (dwell.at(h) - dwell.at(0.0)) / h == pytest.approx(switch.rate, abs=2e-3)
    assert dwell.middle == pytest.approx(least, rel=1e-2)
    if switch.rate < 1.0:
        assert dwell.middle == pytest.approx(least, abs=2e-4)


@pytest.mark.parametrize("duration", [1.5, 4.0, 30.0])
@pytest.mark.parametrize("switch", [SWITCH, Switch(7.243648, 64.73294)])
def test_the_ramp_never_stops(duration, switch):
    integral = integral_exact(ARM, Q_S)
    dwell = RampDwell(integral, duration, switch)
    t = np.linspace(0.0, duration, 20001)
    b = np.array([dwell.at(x) for x in t])
    assert b.min() > 0.5 * integral / duration
    assert np.trapezoid(b, t) == pytest.approx(integral, rel=1e-4)
    assert (b[0], b[-1]) == pytest.approx((switch.b, switch.b))
    h = 1e-7
    assert (dwell.at(h) - dwell.at(0)) / h == pytest.approx(switch.rate, rel=1e-3)


def test_figure_6_as_the_paper_has_it():
    plan = paper(DwellLine())
    assert stay(plan) == pytest.approx(3.9995936, abs=2e-6)
    assert plan.duration == pytest.approx(10.8114, abs=1e-4)
    assert plan.peak_rates[2] == pytest.approx(0.5514, abs=2e-3)
    entered, left = plan.marks["region"]
    within = (plan.t > entered) & (plan.t < left)
    assert np.abs(plan.velocities[within, 2]).min() == pytest.approx(0.0244, abs=2e-3)
    assert len(plan.crossings) == 1


def test_figure_6_with_the_exact_integral():
    plan = paper(DwellLine(), dwell_integral="exact")
    assert stay(plan) == pytest.approx(4.0, abs=1e-9)
    assert plan.duration == pytest.approx(10.8118, abs=1e-4)
    # That the elbow is where it has to be at the end of the dwell is what the integral is for.
    left = plan.marks["region"][1]
    assert np.interp(left, plan.t, plan.inside) == pytest.approx(0.03, abs=1e-5)


@pytest.mark.parametrize("dwell", [1.5, 4.0, 8.0])
def test_our_dwell_is_exact_keeps_going_and_stays_on_the_line(dwell):
    plan = Esc(EscSettings(), ArmGeometry(), 5e-3).prepare(DwellLine(dwell=dwell))
    entered, left = plan.marks["region"]
    assert left - entered == pytest.approx(dwell, abs=1e-9)
    within = (plan.t > entered) & (plan.t < left)
    assert (plan.velocities[within, 2] < -0.01).all(), "the elbow never stops or reverses"
    assert (plan.inside[within] < 0.03 + 1e-9).all()
    assert (plan.inside[~within] > 0.03 - 1e-9).all()
    assert len(plan.crossings) == 1
    assert plan.path_deviation < 1e-9
    assert plan.twist_residual < 1e-9
    assert plan.hand[-1] == pytest.approx(plan.hand[0], abs=1e-6)


def test_the_natural_slope_stops_and_is_refused_with_the_longest_dwell():
    with pytest.raises(InfeasibleMotion, match=r"-0\.13.*at most 3\.44\d? s"):
        paper(DwellLine(), dwell_slope="natural")
    assert stay(paper(DwellLine(dwell=3.4), dwell_slope="natural")) == pytest.approx(3.4, abs=1e-3)


def test_the_printed_speed_is_refused_with_the_longest_dwell():
    with pytest.raises(InfeasibleMotion, match=r"b reaches -5\.6\d+; .*at most 0\.41\d+ s"):
        paper(DwellLine(speed=0.6))
    plan = Esc(EscSettings(), ArmGeometry(rate_limits=(10.0,) * 6), 1e-3).prepare(
        DwellLine(speed=0.6)
    )
    assert stay(plan) == pytest.approx(4.0, abs=1e-9)
    assert len(plan.crossings) == 1


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (
            DwellLine(start=radians(10, 60, 20, -70, 20, 0)),
            "starts inside the region: its wrist is 0.01",
        ),
        (DwellLine(travel=0.1), "does not meet the boundary"),
    ],
)
def test_what_cannot_be_done_is_refused(path, message):
    for law in (
        EscPaper(EscPaperSettings(), ArmGeometry(), 5e-3),
        Esc(EscSettings(), ArmGeometry(), 5e-3),
    ):
        with pytest.raises(InfeasibleMotion, match=message):
            law.prepare(path)
    with pytest.raises(InfeasibleMotion):
        LookAhead(LookAheadSettings(), ArmGeometry(), 5e-3).prepare(path)
