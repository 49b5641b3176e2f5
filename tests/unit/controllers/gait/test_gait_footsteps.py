"""Walks over given footprints: files, numbers, what is refused and why."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from test_gait_drawn import GEOMETRY, model
from test_gait_turning import attitude, sole_of

from controllers.gait.footprints import Footstep, StepNumbers
from controllers.gait.footstep_file import read_footsteps
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.law import check_rates
from controllers.gait.laws import (
    InverseLaw,
    NoSettings,
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


RIGHT = Footstep("right", 0.03, -0.039)
HERE = r"step 1, swing right 1, "
REFUSED = {
    "too long": (
        (RIGHT, Footstep("left", 0.25, 0.039)),
        {},
        r"step 2 \(left\), with .*223\.4 mm away .*reaches 200\.0 mm",
    ),
    "hips too high": (
        (RIGHT,),
        {"hip": 0.199},
        r"step 1 \(right\), with .*: hips at 199\.0 mm .* at 1\d\d\.\d mm all steps would be in",
    ),
    "turned in too far": (
        (Footstep("right", 0.03, -0.07, heading=math.radians(35.0)),),
        {},
        HERE + r"\d+ % of the way: right_hip_yaw would be at 35 deg, outside -90 … 30 deg\. "
        r"From beside the standing foot step 1 by itself would fit as far as .*heading 30\.00 deg",
    ),
    "onto the other foot": (
        (Footstep("right", 0.01, 0.0),),
        {},
        HERE + r".* right sole would overlap the left one by 23 mm\. From .* y -23\.00 mm",
    ),
    "into a tread": (
        (Footstep("right", 0.1, -0.039, height=0.015),),
        {"lift": 0.01},
        HERE + r"1\d % .* right sole would be [\d.]+ mm below where it is to stand\. "
        r"With a lift of \d+ mm step \d by itself would fit\.",
    ),
    "into a tread with a lift of its own": (
        (Footstep("right", 0.1, -0.039, height=0.015, lift=0.012),),
        {"lift": 0.01},
        HERE + r"1\d % .* right sole would be [\d.]+ mm below where it is to stand\. "
        r"Lifted by \d+ mm instead of its own 12 mm step \d by itself would fit\.",
    ),
    "nowhere": (
        (Footstep("right", 0.0, -0.039),),
        {},
        r"step 1: the right foot would come down where it stands",
    ),
    "down a tread, too near": (
        (Footstep("right", 0.095, -0.039, height=-0.016, lift=0.028),),
        {"ahead": 0.008, "follow": 0.025, "shift_time": 3.0},
        r"step 1, swing right 1, 93 % of the way: the right sole would be 8\.\d+ mm below where it "
        r"stood\. .*Step 1 by itself would fit \d mm farther on, at x 10\d\.\d+ mm, y -39\.00 mm,",
    ),
    "an ankle that folds too far": (
        (
            Footstep("left", 0.1035122, 0.039, height=0.0110046),
            Footstep("right", 0.1035122, -0.039, height=0.0110046),
            Footstep("left", 0.2276294, 0.039, height=0.0220093),
            Footstep("right", 0.2070244, -0.039, height=0.0220093),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.0230046},
        r"right_ankle_pitch would be at -60\.\d+ deg, outside -60 … 60 deg\. "
        r"With a lift of 22 mm step 2 by itself would fit\.",
    ),
    "a tread so low that the foot behind cannot follow": (
        (
            Footstep("left", 0.1022557, 0.039, height=-0.0199618),
            Footstep("right", 0.1022557, -0.039, height=-0.0199618),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.0319618},
        r"step 1, shift 1, 100 % of the way: right_ankle_pitch would be at -60\.779 deg, .* "
        r"deg\. With follow at 40 mm step 1 by itself would fit\.",
    ),
    "a tread so low that nothing helps": (
        (
            Footstep("left", 0.1022557, 0.039, height=-0.03),
            Footstep("right", 0.1022557, -0.039, height=-0.03),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.05},
        r"right_ankle_pitch would be at -\d+\.\d+ deg, outside -60 … 60 deg\. No part of",
    ),
    "two heights": (
        (Footstep("right", 0.03, -0.039, height=0.01),),
        {},
        r"step 1, .* before it by \d+\.\d mm, and the ground there would have two heights, 10 ",
    ),
    "slope": (
        (Footstep("right", 0.1, -0.039, roll=0.5),),
        {"lift": 0.05},
        r"step 1, .*right_\w+ would be at .* deg, outside .* deg\.",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_step_that_cannot_be_done_is_refused_with_its_number_and_what_would_fit(what):
    steps, others, words = REFUSED[what]
    with pytest.raises(InfeasibleMotion, match=words):
        phases(steps=steps, **others)


@pytest.mark.parametrize("far", [0.14, 0.15])
def test_hips_too_low_for_one_step_are_told_with_the_step_that_needs_them(far):
    """The hips have one height all along: a step that is too long bends the knees of all others."""
    steps = [
        Footstep("left", 0.03, 0.04, heading=math.radians(8.0)),
        Footstep("right", 0.05, -0.036, heading=math.radians(8.0)),
        Footstep("left", 0.086, 0.046),
        Footstep("right", 0.086 + far, -0.03),
        Footstep("left", 0.086 + far, 0.046),
    ]
    with pytest.raises(InfeasibleMotion) as refused:
        phases(steps=tuple(steps))
    told = str(refused.value)
    assert re.match(r"step 4 needs the hips at \d+\.\d mm .* too low for step [1-3]: ", told), told
    assert "step 4 would fit as far as x" in told
    steps[3] = Footstep(
        "right", float(re.search(r"far as x (\S+) mm", told)[1]) / 1e3 - 1e-4, -0.03
    )
    assert phases(steps=tuple(steps[:4]))


@pytest.mark.parametrize("seed", range(8))
def test_what_is_said_to_fit_does_fit(seed):
    rng = np.random.default_rng((92, seed))
    heading = float(rng.uniform(0.5, 1.2))
    with pytest.raises(InfeasibleMotion) as refused:
        phases(steps=(Footstep("right", 0.03, -0.08, heading=heading),))
    found = re.search(
        r"x (\S+) mm, y (\S+) mm, heading (\S+) deg, height (\S+) mm", str(refused.value)
    )
    x, y, turned, height = (float(number) for number in found.groups())
    fits = np.array((x / 1e3, y / 1e3, math.radians(turned)))
    beside, asked = np.array((0.0, -0.039, 0.0)), np.array((0.03, -0.08, heading))
    share = np.linalg.norm(fits - beside) / np.linalg.norm(asked - beside)
    for change, does in ((-0.01, True), (0.03, False)):
        tried = (beside + (share + change) * (asked - beside)).tolist()
        step = Footstep("right", *tried, height / 1e3)
        if does:
            assert phases(steps=(step,))
        else:
            with pytest.raises(InfeasibleMotion):
                phases(steps=(step,))


def test_rates_and_balance_are_refused_with_step_joint_and_instant_and_what_would_do():
    law = TrapezoidNormLaw(TrapezoidNormSettings(), model(min_margin=0.021), 1e-2)
    walk = FootstepsSettings(numbers=StepNumbers(), speed=8.0)
    with pytest.raises(InfeasibleMotion, match=r"at \d+\.\d+ s \(.* \d\) the zero-m") as refused:
        law.prepare(walk)
    slower = float(re.search(r"at a speed of (\S+) instead of 8", str(refused.value)).group(1))
    law.prepare(replace(walk, speed=slower))
    law = InverseLaw(NoSettings(), model(), 1e-3)
    words = r"at 14\.00\d s \(swing left 2\) left_knee would need 1\d\.\d+ rad/s, beyond"
    with pytest.raises(InfeasibleMotion, match=words):
        check_rates(law.prepare(FootstepsSettings(numbers=StepNumbers())), 1.0)


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


def test_the_speed_that_is_named_is_the_greatest_within_a_hundredth():
    """A stair under which the first guess, 5.927, fits as 5.987 does."""
    lean = 0.02664626539914165
    places = (
        ("left", 0.10120728118811491, 0.04659258056971772, -0.0026974345190152217),
        ("right", 0.14675055772276663, -0.04687280753902729, -0.003911280052572071),
        ("left", 0.19229383425741833, 0.040166892033986136, -0.005125125586128921),
        ("right", 0.23783711079207004, -0.03673290035211312, -0.0063389711196857705),
        ("left", 0.28338038732672177, 0.044119649277952706, -0.007552816653242621),
        ("right", 0.3289236638613735, -0.04287075583675914, -0.008766662186799471),
    )
    steps = tuple(Footstep(foot, x, y, height=height, pitch=lean) for foot, x, y, height in places)
    law = TrapezoidNormLaw(TrapezoidNormSettings(), model(min_margin=5e-3), 5e-3)
    motion = FootstepsSettings(
        steps=steps, first_shift_time=3.0, shift_time=3.83, swing_time=3.47, speed=7.386,
        hip=0.159885, lift=0.013697,
    )  # fmt: skip
    with pytest.raises(InfeasibleMotion) as refused:
        law.prepare(motion)
    named = float(re.search(r"at a speed of (\S+) instead of 7\.386", str(refused.value))[1])
    law.prepare(replace(motion, speed=named))
    with pytest.raises(InfeasibleMotion):
        law.prepare(replace(motion, speed=1.01 * named))


@pytest.mark.parametrize("far", [0.02, 0.025, 0.03, 0.035])
def test_the_time_that_a_swing_is_said_to_need_is_not_said_to_be_too_short(far):
    """Rounded to the nearest it would be refused with its own number, and again."""

    def said(swing_time):
        law = SmoothLaw(SmoothSettings(), model(), 1e-3)  # as motions are planned
        steps = (Footstep("right", far, -0.039),)
        try:
            law.prepare(FootstepsSettings(steps=steps, swing_time=swing_time))
        except InfeasibleMotion as refused:
            words = r"swing right 1: .* more than (\S+) rad/s\^2 .* at least (\S+) s instead"
            return re.search(words, str(refused)).groups()
        return None

    bound, needed = said(1.0)
    again = said(float(needed))
    assert again is None or again[0] != bound


@pytest.mark.parametrize("law", ["sc-smooth", "sc-trapezoid", "own times"])
def test_the_times_that_a_refusal_names_are_enough_for_the_whole_walk(law, tmp_path):
    """Corners of the joints' curve count more in the time that is named for a phase alone."""
    footsteps = [
        Footstep("right", 0.0104511, -0.0458708),
        Footstep("left", 0.0209022, 0.0458708),
        Footstep("right", 0.0313534, -0.0458708),
        Footstep("left", 0.0454828, 0.0458708),
    ]
    walk = FootstepsSettings(
        steps=tuple(footsteps), ahead=0.003347, first_shift_time=2.5, last_shift_time=2.5,
        shift_time=0.9265, swing_time=1.356, speed=0.7,
    )  # fmt: skip
    smooth = SmoothLaw(SmoothSettings(), model(), 5e-3)
    smooth.finer(1e-3)
    if law == "sc-trapezoid":
        walk = replace(walk, speed=8.0, swing_time=2.5)
        smooth = TrapezoidNormLaw(TrapezoidNormSettings(), model(response_time=1.0), 5e-3)
    if law == "own times":
        file = tmp_path / "prints.csv"
        rows = [f"{s.foot}, {1e3 * s.x}, {1e3 * s.y}, 0.93, 1.35" for s in footsteps]
        file.write_text("\n".join(["foot, x (mm), y (mm), shift (s), swing (s)", *rows]))
        walk = replace(walk, steps=(), file=file)
    with pytest.raises(InfeasibleMotion, match=r"With .* the whole motion would fit") as refused:
        smooth.prepare(walk)
    times = str(refused.value).rpartition(" With ")[2]
    named = re.findall(r"(\w+_time) at ([\d.]+) s instead of", times)
    own = re.findall(r"the (\w+) of step (\d) \(line (\d)\) at ([\d.]+) s instead of", times)
    assert len(own) == (7 if law == "own times" else 0)
    assert bool(named) == (law != "own times")
    for key, number, line, time in own:
        assert int(line) == int(number) + 1
        footsteps[int(number) - 1] = replace(footsteps[int(number) - 1], **{key: float(time)})
    longer = replace(walk, file=None, steps=tuple(footsteps))
    smooth.prepare(replace(longer, **{key: float(time) for key, time in named}))


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


def test_a_print_that_is_off_the_ground_it_shares_is_told_its_height_there():
    """On a slope each print overlaps the one before it; in hundredths they lie on one ground."""
    slope = {"pitch": math.radians(-1.78), "roll": math.radians(-0.53)}
    start = {"start_pitch": slope["pitch"], "start_roll": slope["roll"], "lift": 0.022}
    normal = attitude(slope["roll"], slope["pitch"], 0.0)[:, 2]

    def height(x, y):
        return -(normal[0] * x + normal[1] * y) / normal[2]

    steps = [
        Footstep(foot, x, y, height=round(height(x, y), 5), **slope)
        for foot, x, y in (("left", 0.015, 0.039), ("right", 0.033, -0.039), ("left", 0.05, 0.039))
    ]
    phases(steps=tuple(steps), **start)
    high = replace(steps[2], height=steps[2].height + 6e-4)
    with pytest.raises(InfeasibleMotion, match=r"two heights, 0\.[56]\d* mm apart") as refused:
        phases(steps=(*steps[:2], high), **start)
    told = float(re.search(r"With a height of (\S+) mm it would lie", str(refused.value))[1])
    assert told / 1e3 == pytest.approx(steps[2].height, abs=2e-5)
    phases(steps=(*steps[:2], replace(high, height=told / 1e3)), **start)
    flat = replace(steps[2], pitch=0.0, roll=0.0)
    with pytest.raises(InfeasibleMotion, match="two heights") as refused:
        phases(steps=(*steps[:2], flat), **start)
    words = r"height of (\S+) mm, a pitch of (\S+) deg and a roll of (\S+) deg it would lie"
    up, pitch, roll = map(float, re.search(words, str(refused.value)).groups())
    tilts = {"pitch": math.radians(pitch), "roll": math.radians(roll)}
    phases(steps=(*steps[:2], replace(flat, height=up / 1e3, **tilts)), **start)


@pytest.mark.parametrize("rise", [0.008, 0.013, 0.017])
def test_the_lift_that_is_named_is_the_least_that_fits(rise):
    step = Footstep("right", 0.1, -0.039, height=rise)
    with pytest.raises(InfeasibleMotion, match="With a lift of") as refused:
        phases(steps=(step,), lift=0.01)
    lift = int(re.search(r"With a lift of (\d+) mm", str(refused.value))[1])
    phases(steps=(step,), lift=1e-3 * lift)
    with pytest.raises(InfeasibleMotion):
        phases(steps=(step,), lift=1e-3 * (lift - 1))
