"""A plan that breaks what its law promises is refused, with a speed at which it does not."""

import dataclasses
import math
import re
import time

import numpy as np
import pytest
from arm_cases import GEOMETRIES, START_FIG4, radians
from drawn_cases import WIDE, faults_of
from scipy.optimize import minimize_scalar

from controllers.arm.dwell import elbow_at_depth
from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import Circle, DwellLine, Line, TurnBack
from controllers.arm.region import region_for_twist
from controllers.motion import InfeasibleMotion

PERIOD = 1e-2
FREE = ArmGeometry(**WIDE)
LAWS = {"esc": (Esc, EscSettings()), "paper": (EscPaper, EscPaperSettings())}


def plan(path, law="esc", geometry=FREE):
    kind, settings = LAWS[law]
    return kind(settings, geometry, PERIOD).prepare(path)


def refusal(path, law="esc", geometry=FREE):
    with pytest.raises(InfeasibleMotion) as refused:
        plan(path, law, geometry)
    return str(refused.value)


def drawn_dwells(count):
    rng = np.random.default_rng(41)
    for _ in range(count):
        speed, depth = 10 ** rng.uniform((-0.9, -2.3), (-0.1, -1.0))
        yield DwellLine(speed=float(speed), depth=float(depth), dwell=float(rng.uniform(2, 9)))


def drawn_circles(count):
    rng = np.random.default_rng(42)
    for _ in range(count):
        yield Circle(radius=float(rng.uniform(0.05, 0.3)), rate=float(rng.uniform(1.5, 6.0)))


def check_claim(message, path, slower, period=PERIOD):
    """The joint and its number are those of the plan without the limit, the remedy is one."""
    found = re.search(r"(q\d) would need (\S+) rad/s, beyond its limit of (\S+) rad/s", message)
    joint, number, limit = AXIS_NAMES.index(found[1]), float(found[2]), float(found[3])
    limitless = dataclasses.replace(FREE, rate_limits=(1e3,) * 6)
    free = Esc(EscSettings(), limitless, period).prepare(path)
    assert np.abs(free.velocities[:, joint]).max() == pytest.approx(number, rel=1e-3)
    assert limit == FREE.rate_limits[joint]
    fitting = slower(message)
    assert faults_of(FREE, fitting, plan(fitting), range(6), ()) == []
    faster = dataclasses.replace(fitting, **{
        name: getattr(fitting, name) * share
        for name, share in (("rate", 1.01), ("speed", 1.01), ("dwell", 1 / 1.01))
        if hasattr(fitting, name)
    })  # fmt: skip
    assert "beyond its limit" in refusal(faster)


@pytest.mark.parametrize("path", list(drawn_dwells(5)))
def test_a_dwell_that_is_too_fast_names_joint_rate_and_what_would_fit(path):
    def slower(message):
        named = re.search(r"at (\S+) m/s with a dwell of (\S+) s it would fit", message)
        return dataclasses.replace(path, speed=float(named[1]), dwell=float(named[2]))

    check_claim(refusal(path), path, slower, 0.1 * PERIOD)  # its peak is between the samples


@pytest.mark.parametrize("seed", range(6))
def test_a_very_shallow_dwell_is_refused_at_once_with_the_speed_that_its_border_needs(seed):
    """q3 needs ``v R / (a2 a3 S3)`` there on a radial line, wherever the samples are."""
    rng = np.random.default_rng((44, seed))
    depth, speed = float(10 ** rng.uniform(-9, -4)), float(10 ** rng.uniform(-1.5, -0.5))
    path = DwellLine(START_FIG4, (1.0, 0.0, 0.0), speed, depth, dwell=2.0)
    q = plan(dataclasses.replace(path, depth=0.01, speed=0.01)).positions  # the same line
    near = q[np.argmin(np.abs(np.sin(q[:, 2])))]
    lean = near[1] + 0.5 * near[2]
    radial = math.sin(lean) * math.cos(near[0])
    a2, a3 = FREE.a2, FREE.a3
    radius = a2 + a3 - depth
    cosine = (radius**2 - a2**2 - a3**2) / (2.0 * a2 * a3)
    sine = math.sqrt((1.0 - cosine) * (1.0 + cosine))
    needed = speed * radial * radius / (a2 * a3 * sine)
    begun = time.process_time()
    message = refusal(path)
    assert time.process_time() - begun < 5.0
    found = re.search(r"q3 would need (\S+) rad/s.*; at (\S+) m/s with a dwell of", message)
    assert float(found[1]) == pytest.approx(needed, rel=6e-2)
    assert float(found[1]) >= 0.999 * needed
    assert speed / float(found[2]) == pytest.approx(float(found[1]), rel=5e-3)


def test_a_slower_motion_that_takes_too_long_is_said_to():
    law = Esc(EscSettings(), FREE, PERIOD)
    law.longest = 1800.0
    with pytest.raises(InfeasibleMotion, match=r"it would fit, but take at least \S+ s, and the l"):
        law.prepare(DwellLine(depth=1e-9))


@pytest.mark.parametrize("path", list(drawn_circles(5)))
def test_a_circle_that_is_too_fast_names_joint_rate_and_what_would_fit(path):
    def slower(message):
        named = re.search(r"at a rate of (\S+) rad/s round the circle it would fit", message)
        return dataclasses.replace(path, rate=float(named[1]))

    check_claim(refusal(path), path, slower)


def test_the_papers_law_is_held_to_the_elbow_alone():
    circle = Circle(rate=1.05)
    assert "q3 would need" in refusal(dataclasses.replace(circle, rate=4.0), "paper")
    assert plan(circle, "paper").peak_rates[3:].max() > 2.0
    assert "q6 would need" in refusal(circle)


@pytest.mark.parametrize("seed", range(12))
def test_a_long_or_shallow_dwell_lasts_as_long_as_it_was_asked_to(seed):
    rng = np.random.default_rng((43, seed))
    path = DwellLine(
        speed=float(10 ** rng.uniform(-2, -0.5)),
        depth=float(10 ** rng.uniform(-3, -1.2)),
        dwell=float(10 ** rng.uniform(0.7, 1.5)),
    )
    limitless = dataclasses.replace(FREE, rate_limits=(1e3,) * 6)
    made = plan(path, geometry=limitless)
    entered, left = made.marks["region"]
    assert left - entered == pytest.approx(path.dwell, rel=1e-9)
    border = np.interp((entered, left), made.t, made.inside)
    fastest = np.abs(np.diff(made.inside)).max()  # what one period blurs
    np.testing.assert_allclose(border, path.depth, atol=fastest)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_a_depth_at_which_the_arm_is_folded_is_refused_with_that_depth(name):
    geometry = GEOMETRIES[name]
    arm = dimensions_of(geometry)
    folded = 2.0 * min(arm.a2, arm.a3)
    assert elbow_at_depth(arm, 0.999 * folded) > 0.9 * math.pi
    for share in (1.0, 1.3, 4.0):
        with pytest.raises(InfeasibleMotion, match=f"no less than {folded:g} m"):
            elbow_at_depth(arm, share * folded)


@pytest.mark.parametrize("seed", range(8))
def test_the_region_of_a_turning_tool_is_the_greatest_that_is_asked_for(seed):
    rng = np.random.default_rng((44, seed))
    geometry = ArmGeometry(d6=float(rng.uniform(0.0, 0.3)))
    v, w = (10 ** rng.uniform((-3, -2), (0, 1))).tolist()

    def asked(u):
        f = 0.5 * (3.0 - u * u)
        return f * (v + geometry.d6 * w * u * f)

    best = minimize_scalar(lambda u: -asked(u), bounds=(0, 1), options={"xatol": 1e-12})
    greatest = max(-best.fun, asked(0.0), asked(1.0))
    share = geometry.reach / (geometry.a2 * geometry.forearm * geometry.rate_limits[2])
    assert region_for_twist(geometry, v, w) == pytest.approx(share * greatest, rel=1e-13)


def at_wrist(s5=0.0):
    q1, q2, q3, q4, _, q6 = START_FIG4
    return (q1, q2, q3, q4, s5, q6)


def at_shoulder(c=0.0):
    q1, _, q3, q4, q5, q6 = START_FIG4
    lean = math.atan2(FREE.a3 * math.sin(q3), FREE.a2 + FREE.a3 * math.cos(q3))
    radius = math.sqrt(FREE.a2**2 + FREE.a3**2 + 2 * FREE.a2 * FREE.a3 * math.cos(q3))
    return (q1, math.asin(c / radius) - lean, q3, q4, q5, q6)


SIDEWAYS = {"direction": (1.0, 0.3, 0.1), "turn_rate": 0.0, "speed": 0.05}


@pytest.mark.parametrize("law", ["esc", "paper", "look-ahead"])
@pytest.mark.parametrize(("start", "name"), [(at_wrist, "wrist"), (at_shoulder, "shoulder")])
def test_a_start_at_a_singularity_that_would_jump_is_refused(law, start, name):
    path = TurnBack(start=start(), **SIDEWAYS)
    with pytest.raises(InfeasibleMotion, match=f"starts at the {name}'s singularity"):
        if law == "look-ahead":
            LookAhead(LookAheadSettings(), FREE, PERIOD).prepare(path)
        else:
            plan(path, law)


@pytest.mark.parametrize("start", [at_wrist, at_shoulder])
@pytest.mark.parametrize("near", [2e-6, 1e-4, 1e-2])
def test_a_start_beside_it_stays_on_its_path(start, near):
    path = TurnBack(start=start(near), **SIDEWAYS)
    made = plan(path)
    assert made.outcome == "done"
    assert faults_of(FREE, path, made, range(6), ()) == []


@pytest.mark.parametrize("law", ["esc", "paper"])
def test_a_start_at_the_wrists_singularity_that_asks_nothing_of_it_is_passed(law):
    q1, q2, q3, _, _, _ = radians(20, 30, 115, 0, 0, 0)
    ahead = (math.cos(q1), math.sin(q1), 0.0)
    path = TurnBack(start=(q1, q2, q3, 0.0, 0.0, 0.0), direction=ahead, turn_rate=0.0)
    made = plan(path, law)
    assert made.outcome == "done"
    assert faults_of(FREE, path, made, (2,), ()) == []
    assert np.abs(made.velocities[:, [0, 3, 5]]).max() < 1e-6


@pytest.mark.parametrize("seed", range(2))
def test_the_papers_law_slows_on_its_way_past_shoulder_and_wrist(seed):
    rng = np.random.default_rng((45, seed))
    c = float(rng.uniform(5e-3, 15e-3))
    path = TurnBack(start=at_shoulder(0.1), speed=0.05, turn_rate=0.0,
                    direction=(-1.0, c / 0.1, 0.3))  # fmt: skip
    without = EscPaperSettings(shoulder_region=0.0, wrist_region=0.0)
    free = EscPaper(without, FREE, 2e-3).prepare(path)
    slowed = EscPaper(EscPaperSettings(), FREE, PERIOD).prepare(path)
    assert free.peak_rates[0] > 2.0
    assert slowed.peak_rates[0] <= 1.001
    assert faults_of(FREE, path, slowed, (0, 2), ()) == []


def test_the_regions_may_be_given_as_numbers():
    wide = Esc(EscSettings(elbow_region=0.8), FREE, PERIOD).prepare(TurnBack(turn_rate=0.0))
    entered, left = wide.marks["region"]
    within = (wide.t > entered) & (wide.t < left)
    assert np.abs(wide.indices[within, 1]).max() == pytest.approx(0.8, abs=5e-3)
    with pytest.raises(InfeasibleMotion, match="q3 would need"):
        EscPaper(EscPaperSettings(elbow_region=0.3), FREE, PERIOD).prepare(TurnBack(turn_rate=0.0))


def test_a_hand_off_its_path_is_refused_with_the_rate_at_which_it_is_not():
    """Beside the wrist's singularity q4 turns by radians in a period, and the hand swerves."""
    path = Line(middle=(0.8, 0.4, 2.0, 0.2, 3e-4, 0.0), direction=(0.8, 0.6, -0.1))
    law = EscPaper(EscPaperSettings(wrist_region=0.0), FREE, PERIOD)
    with pytest.raises(InfeasibleMotion) as refused:
        law.prepare(path)
    message = str(refused.value)
    assert re.search(
        r"after \S+ s the hand would be \S+ mm off its path, more than 0\.001", message
    )
    named = float(re.search(r"at (\S+) m/s it would fit", message)[1])
    slower = dataclasses.replace(path, speed=named)
    assert faults_of(FREE, slower, law.prepare(slower), (), ()) == []


def test_a_slower_dwell_that_is_refused_for_another_reason_says_that_reason():
    narrow = dataclasses.replace(FREE, position_max=(20.0, 20.0, 20.0, 20.0, 0.7, 20.0))
    path = DwellLine(depth=1e-3)
    law = Esc(EscSettings(), narrow, PERIOD)
    slow = dataclasses.replace(path, speed=0.01, dwell=24.0)
    with pytest.raises(InfeasibleMotion, match=r"^after \S+ s q5 would be at"):
        law.prepare(slow)
    said = (
        r"q3 would need .*; at \S+ m/s with a dwell of \S+ s it would be refused, too: .* q5 would"
    )
    with pytest.raises(InfeasibleMotion, match=said):
        law.prepare(path)
