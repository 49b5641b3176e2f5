"""Walks over given footprints: from steps, files and numbers, and on slopes."""

import math

import numpy as np
import pytest
from test_gait_drawn import GEOMETRY, model
from test_gait_turning import attitude, sole_of

from controllers.gait.footprints import Footstep, StepNumbers
from controllers.gait.footstep_file import read_footsteps
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.laws import (
    TrapezoidNormLaw,
    TrapezoidNormSettings,
)
from controllers.gait.smooth import SmoothLaw, SmoothSettings
from controllers.motion import InfeasibleMotion

OFF = 1e-6


def plan(**settings):
    law = TrapezoidNormLaw(TrapezoidNormSettings(), model(), 2e-2)
    return law.prepare(FootstepsSettings(**settings))


def phases(**settings):
    return FootstepsSettings(**settings).phases(GEOMETRY)


def prints_of(made):
    """Return where each foot stands during each phase, by kinematics of the test's own."""
    stood = []
    for planned in made.phases:
        for leg, stands in enumerate(planned.phase.standing):
            if not stands:
                continue
            for sample in range(planned.first + 1, planned.last + 1, 17):
                joints = made.q[sample, 6 * leg : 6 * leg + 6]
                at, foot = sole_of(joints, leg, made.waist[sample], made.yaw[sample])
                stood.append((planned.phase.name, leg, at, foot))
    return stood


def draw_steps(seed):
    """Return footprints: on level ground anyhow, or far apart on ground that tilts and climbs."""
    rng = np.random.default_rng((91, seed))
    climbs = seed % 2
    feet = [np.array((0.0, -0.039, 0.0, 0.0)), np.array((0.0, 0.039, 0.0, 0.0))]
    leg, steps = int(rng.integers(2)), []
    for number in range(4 if climbs else int(rng.integers(2, 5))):
        x, y, z, heading = feet[1 - leg]
        aside = (1.0 if leg else -1.0) * rng.uniform(0.078, 0.095)
        ahead, turn = rng.uniform(-0.03, 0.04), rng.uniform(-0.06, 0.06)
        tilt, rise = np.zeros(2), 0.0
        if climbs:
            ahead = rng.uniform(0.098, 0.102) if number % 2 == 0 else 0.0
            tilt, turn = rng.uniform(-0.03, 0.03, 2), 0.0
            rise = rng.uniform(-0.004, 0.004)
        s, c = math.sin(heading), math.cos(heading)
        at = np.array(
            (x + c * ahead - s * aside, y + s * ahead + c * aside, z + rise, heading + turn)
        )
        steps.append(
            Footstep("left" if leg else "right", *at[:2].tolist(), float(at[3]), float(at[2]),
                     float(tilt[0]), float(tilt[1]))
        )  # fmt: skip
        feet[leg], leg = at, 1 - leg
    return tuple(steps)


@pytest.mark.parametrize("seed", range(6))
def test_feet_stand_on_their_footprints_and_nowhere_else(seed):
    steps = draw_steps(seed)
    made = plan(steps=steps, lift=0.022, follow=0.025)
    last = {0: (np.array((0, -0.039, 0)), np.eye(3)), 1: (np.array((0, 0.039, 0)), np.eye(3))}
    landed = 0
    for name, leg, at, foot in prints_of(made):
        while name.startswith("shift") and landed < int(name.split()[1]):
            step = steps[landed]
            wanted = attitude(step.roll, step.pitch, step.heading)
            last[int(step.foot == "left")] = (np.array((step.x, step.y, step.height)), wanted)
            landed += 1
        np.testing.assert_allclose(at, last[leg][0], atol=OFF)
        np.testing.assert_allclose(foot, last[leg][1], atol=OFF)
    assert landed == len(steps)
    low, high = np.array(GEOMETRY.limits).T
    assert (made.q >= low - 1e-8).all()
    assert (made.q <= high + 1e-8).all()
    assert made.mismatch() < 1e-6
    assert made.off_path < 1e-6


def test_numbers_straight_on_are_the_footprints_of_a_walk():
    steps = FootstepsSettings(numbers=StepNumbers(count=3, length=0.04)).footsteps(GEOMETRY)
    assert [step.foot for step in steps] == ["right", "left", "right", "left"]
    assert [step.x for step in steps] == pytest.approx([0.04, 0.08, 0.12, 0.12])
    assert {round(step.y, 9) for step in steps} == {-0.039, 0.039}


def test_numbers_that_turn_lie_on_a_circle():
    steps = FootstepsSettings(
        numbers=StepNumbers(count=8, length=0.03, turn=0.1, width=0.08, first="left", close=False)
    ).footsteps(GEOMETRY)
    # Chords of a circle whose centre is to the left, square to the first half turn.
    radius = 0.015 / math.sin(0.05)
    out = {"left": -0.04, "right": 0.04}
    for step in steps:
        distance = math.hypot(step.x, step.y - radius)
        assert distance == pytest.approx(radius + out[step.foot], abs=1e-9)


def test_numbers_on_stairs_bring_the_feet_together_on_each_tread():
    steps = FootstepsSettings(
        numbers=StepNumbers(count=2, length=0.1, rise=0.01, together=True)
    ).footsteps(GEOMETRY)
    assert [(s.foot, round(s.x, 3), round(s.height, 3)) for s in steps] == [
        ("right", 0.1, 0.01), ("left", 0.1, 0.01), ("right", 0.2, 0.02), ("left", 0.2, 0.02),
    ]  # fmt: skip


def test_first_foot_hip_and_waist_are_as_asked_for():
    made = plan(
        numbers=StepNumbers(count=2, first="left", length=0.02), hip=0.185, ahead=0.01, lift=0.015
    )
    assert made.phases[1].phase.name == "swing left 1"
    np.testing.assert_allclose(made.waist[:, 2] - GEOMETRY.ankle_height, 0.185, atol=1e-9)
    swing = made.phases[1]
    assert made.waist[swing.last, 0] == pytest.approx(0.01, abs=1e-9)
    assert made.waist[-1, 0] == pytest.approx(0.05, abs=1e-9)


def test_the_same_foot_may_swing_twice():
    made = plan(
        steps=(
            Footstep("left", 0.0, 0.059, lift=0.01),
            Footstep("left", 0.02, 0.059, lift=0.01, swing=3.0),
        )
    )
    names = [planned.phase.name for planned in made.phases]
    assert names == ["shift 0", "swing left 1", "swing left 2", "shift 2"]
    assert made.phases[2].phase.duration == 3.0


FILE = """# a bend
foot, x (mm), y (cm), heading (deg), lift (mm), swing (s)

right, 30, -3.9, 5, , 2.5
left, 60, 4.2, 10, 15,
"""


def test_a_file_says_the_same_as_the_experiment(tmp_path):
    path = tmp_path / "steps.csv"
    path.write_text(FILE)
    steps = read_footsteps(path)
    first = steps[0]
    assert (first.foot, first.lift, first.swing) == ("right", None, 2.5)
    assert (first.x, first.y, first.heading) == pytest.approx((0.03, -0.039, math.radians(5.0)))
    assert (steps[1].lift, steps[1].swing) == (pytest.approx(0.015), None)
    assert len(phases(file=str(path))) == 5


def test_a_step_that_cannot_be_is_told_with_its_line(tmp_path):
    path = tmp_path / "steps.csv"
    far = "foot, x (mm), y (mm)\n# there\nright, 30, -39\n\nleft, 60, 39\nright, 400, -39\n"
    path.write_text(far)
    law = SmoothLaw(SmoothSettings(), model(), 5e-3)
    with pytest.raises(InfeasibleMotion, match=r"step 3 \(steps.csv, line 6\)"):
        law.prepare(FootstepsSettings(file=path))
    path.write_text("foot, x (mm), y (mm)\nright, 30, -39\nleft, 60, 39\n")
    quick = {"shift_time": 0.4, "swing_time": 0.4, "first_shift_time": 3.0}
    with pytest.raises(InfeasibleMotion, match=r"^swing right 1 \(steps.csv, line 2\): with no"):
        law.prepare(FootstepsSettings(file=path, **quick))
    for shift, line in ((0, 2), (1, 3), (2, 3)):
        words = FootstepsSettings(file=path).with_line(f"shift {shift}: too short.")
        assert words == f"shift {shift} (steps.csv, line {line}): too short."


WRONG = {
    "": r"steps\.csv: the file is empty",
    "foot, x (mm)\n": r"line 1: the header has no y; it has foot, x \(mm\)",
    "foot, x (mm), y (mm), headin (deg)\n": r"line 1, column 4: .* did you mean heading\?",
    "foot, x, y (mm)\n": r"line 1, column 2: x has no unit; write it as x \(m\), with",
    "foot, x (deg), y (mm)\n": r"column 2: x has the unit 'deg'",
    "foot, x (mm), y (mm), x (m)\n": r"column 4: x is there already",
    "foot, x (mm), y (mm)\nright, 3\n": r"line 2: 2 cells under a header of 3",
    "foot, x (mm), y (mm)\nmiddle, 3, 4\n": r"line 2, foot: 'middle' is neither right nor left",
    "foot, x (mm), y (mm)\nright, three, 4\n": r"line 2, x: 'three' is no number",
    "foot, x (mm), y (mm)\nright, 1_000, 4\n": r"line 2, x: '1_000' is no number",
    "foot, x (mm), y (mm)\nright, nan, 4\n": r"line 2, x: 'nan' is no number",
    "foot, x (mm), y (mm)\nright, inf, 4\n": r"line 2, x: 'inf' is no number",
    "foot, x (mm), y (mm), pitch (deg)\n\nleft, 1, 2, 45\n": r"line 3, pitch: 45 deg is outside",
    "foot, x (mm), y (mm)\n": r"0 footprints; there may be 1 to 200",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_file_is_refused_with_line_and_column(tmp_path, text):
    path = tmp_path / "steps.csv"
    path.write_text(text)
    with pytest.raises(InfeasibleMotion, match=WRONG[text]):
        read_footsteps(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InfeasibleMotion, match="no-such"):
        phases(file=str(tmp_path / "no-such.csv"))


def test_exactly_one_source_of_footprints():
    with pytest.raises(ValueError, match="exactly one of file, steps and numbers"):
        FootstepsSettings()


@pytest.mark.parametrize("seed", range(6))
def test_a_walk_begins_on_a_slope_and_goes_on_over_it(seed):
    """Soles lie on one plane from the first instant, the waist is upright midway over them."""
    rng = np.random.default_rng((93, seed))
    pitch, roll = rng.uniform(-0.08, 0.08), rng.uniform(-0.05, 0.05)
    numbers = StepNumbers(
        count=3, length=rng.uniform(0.0, 0.03), turn=rng.uniform(-0.06, 0.06),
        first=("right", "left")[seed % 2],
    )  # fmt: skip
    walk = {"start_pitch": pitch, "start_roll": roll, "ahead": 0.004, "sway": 0.9}
    made = plan(numbers=numbers, **walk)
    normal = attitude(roll, pitch, 0.0)[:, 2]
    stood = prints_of(made)
    assert len(stood) > 20
    for _, _, at, foot in stood:
        assert abs(normal @ at) < OFF
        np.testing.assert_allclose(foot[:, 2], normal, atol=1e-9)
    soles = [sole_of(made.q[0, 6 * leg : 6 * leg + 6], leg, made.waist[0], 0.0) for leg in (0, 1)]
    for (at, foot), side in zip(soles, (-0.039, 0.039), strict=True):
        np.testing.assert_allclose(at[:2], (0.0, side), atol=OFF)
        np.testing.assert_allclose(foot, attitude(roll, pitch, 0.0), atol=1e-9)
    ankles = [at + GEOMETRY.ankle_height * foot[:, 2] for at, foot in soles]
    np.testing.assert_allclose(
        made.waist[0, :2], np.add(np.mean(ankles, axis=0)[:2], (0.004, 0.0)), atol=OFF
    )
    # The same, print by print.
    steps = FootstepsSettings(numbers=numbers, **walk).footsteps(GEOMETRY)
    np.testing.assert_array_equal(plan(steps=steps, **walk).q, made.q)
