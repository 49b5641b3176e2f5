"""What is refused of a walk over footprints, and what is said to fit."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from gait_advice import follow_advice
from test_gait_drawn import model
from test_gait_footsteps import phases
from test_gait_turning import attitude

from controllers.gait.footprints import Footstep, StepNumbers
from controllers.gait.footstep_numbers import number_footsteps
from controllers.gait.footsteps import FootstepsSettings
from controllers.gait.geometry import LegGeometry
from controllers.gait.ground_plane import GroundPlane
from controllers.gait.law import check_rates
from controllers.gait.laws import (
    InverseLaw,
    NoSettings,
    TrapezoidNormLaw,
    TrapezoidNormSettings,
)
from controllers.gait.smooth import SmoothLaw, SmoothSettings
from controllers.motion import InfeasibleMotion

GEOMETRY = LegGeometry()
MARGIN = 0.005
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
        r"With a lift of \d+ mm all steps would fit\.",
    ),
    "into a tread with a lift of its own": (
        (Footstep("right", 0.1, -0.039, height=0.015, lift=0.012),),
        {"lift": 0.01},
        HERE + r"1\d % .* right sole would be [\d.]+ mm below where it is to stand\. "
        r"Lifted by \d+ mm instead of 12 mm step \d by itself would fit\.",
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
        r"With follow at 35 mm all steps would fit\.",
    ),
    "a tread so low that the foot behind cannot follow": (
        (
            Footstep("left", 0.1022557, 0.039, height=-0.0199618),
            Footstep("right", 0.1022557, -0.039, height=-0.0199618),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.0319618},
        r"step 1, shift 1, 100 % of the way: right_ankle_pitch would be at -60\.779 deg, .* "
        r"deg\. With .* follow at \d+ mm and every x times 1\.\d all steps would fit\.",
    ),
    "a tread so low that no step by itself would do": (
        (
            Footstep("left", 0.1022557, 0.039, height=-0.03),
            Footstep("right", 0.1022557, -0.039, height=-0.03),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.05},
        r"right_ankle_pitch would be at -\d+\.\d+ deg, outside -60 … 60 deg\. "
        r"With .* follow at \d+ mm and every height times 0\.\d all steps would fit\.",
    ),
    "a tread so low that nothing helps": (
        (
            Footstep("left", 0.1022557, 0.039, height=-0.03),
            Footstep("right", 0.1022557, -0.039, height=-0.03),
        ),
        {"ahead": 0.008, "follow": 0.025, "lift": 0.05, "hip": 0.12},
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


def with_a_long_step(far):
    return [
        Footstep("left", 0.03, 0.04, heading=math.radians(8.0)),
        Footstep("right", 0.05, -0.036, heading=math.radians(8.0)),
        Footstep("left", 0.086, 0.046),
        Footstep("right", 0.086 + far, -0.03),
        Footstep("left", 0.086 + far, 0.046),
    ]


@pytest.mark.parametrize("far", [0.14, 0.15, 0.16, 0.165])
def test_hips_too_low_for_one_step_are_told_with_the_step_that_needs_them(far):
    """The hips have one height all along: a step that is too long bends the knees of all others.

    Up to 0.15 m another manner of walking does, beyond it only the step can be shorter.
    """
    steps = with_a_long_step(far)
    settings = FootstepsSettings(steps=tuple(steps))
    with pytest.raises(InfeasibleMotion) as refused:
        settings.phases(GEOMETRY, MARGIN)
    told = str(refused.value)
    assert re.match(r"step 4 needs the hips at \d+\.\d mm .* too low for step [1-3]: ", told), told
    assert ("all steps would fit" in told) == (far <= 0.15)
    assert ("step 4 would fit as far as x" in told) == (far > 0.15)
    settings, steps = follow_advice(told, settings, steps)
    # What fits of step 4 is said without what comes after it.
    fits = steps if far <= 0.15 else steps[:4]
    assert replace(settings, steps=tuple(fits)).phases(GEOMETRY, MARGIN)


def test_the_step_that_is_too_long_is_blamed_and_not_the_one_before_it():
    """In the shift before it a leg folds already, as the hips have one height all along."""
    places = ((0.04, 0.039, 0.0), (0.2, -0.039, 0.0), (0.12, 0.039, 0.17), (0.158, -0.03, 0.35))
    steps = [
        Footstep(("left", "right")[k % 2], x, y, heading=heading)
        for k, (x, y, heading) in enumerate(places)
    ]
    settings = FootstepsSettings(steps=tuple(steps))
    with pytest.raises(InfeasibleMotion, match=r"step 2 needs the hips at .* too low for step 1"):
        settings.phases(GEOMETRY, MARGIN)


@pytest.mark.parametrize(("follow", "ahead"), [(0.04, 0.008), (0.025, 0.02), (0.02, -0.02)])
def test_a_waist_too_far_from_the_standing_foot_is_told_where_it_would_stand(follow, ahead):
    """However slow, the robot would tip over; reach alone would allow it."""
    stairs = StepNumbers(count=3, length=0.1, rise=0.01, together=True)
    settings = FootstepsSettings(numbers=stairs, follow=follow, ahead=ahead, lift=0.025)
    assert settings.phases(GEOMETRY)
    words = (
        r"centre of mass would be -?\d+\.\d mm \w+ .* the bound is 5 mm inside\. With .* all steps"
    )
    with pytest.raises(InfeasibleMotion, match=words) as refused:
        settings.phases(GEOMETRY, MARGIN)
    other, _ = follow_advice(str(refused.value), settings, [])
    assert SmoothLaw(SmoothSettings(), model(), 5e-3).prepare(other).static_margin >= MARGIN


@pytest.mark.parametrize("seed", range(8))
def test_what_is_said_to_fit_does_fit(seed):
    rng = np.random.default_rng((92, seed))
    heading = float(rng.uniform(0.5, 1.2))
    with pytest.raises(InfeasibleMotion) as refused:
        phases(steps=(step := Footstep("right", 0.03, -0.08, heading=heading),))
    found = re.search(
        r"x (\S+) mm, y (\S+) mm, heading (\S+) deg, height (\S+) mm", str(refused.value)
    )
    if found is None:  # the waist helps: a foot aside turns the ankles
        settings, steps = follow_advice(
            str(refused.value), FootstepsSettings(steps=(step,)), [step]
        )
        assert replace(settings, steps=tuple(steps)).phases(GEOMETRY)
        return
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


@pytest.mark.parametrize("seed", range(12))
def test_stairs_that_are_said_to_fit_as_a_whole_do_fit(seed):
    """Too short for the sole, or too steep for the ankle of the foot that stays behind."""
    rng = np.random.default_rng((2711, seed))
    down = StepNumbers(
        count=3, length=rng.uniform(0.082, 0.092), rise=-rng.uniform(0.014, 0.024), together=True
    )
    settings = {"ahead": 0.008, "follow": 0.025, "lift": 0.022}
    with pytest.raises(InfeasibleMotion) as refused:
        phases(numbers=down, **settings)
    told = str(refused.value)
    assert "all steps would fit" in told
    asked = FootstepsSettings(numbers=down, **settings)
    manner, steps = follow_advice(told, asked, list(asked.footsteps(GEOMETRY)))
    assert replace(manner, numbers=None, steps=tuple(steps)).phases(GEOMETRY)


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


@pytest.mark.parametrize("sway", [0.2, 1.9])
def test_a_waist_that_goes_too_far_aside_or_not_far_enough_is_told_how_far(sway):
    steps = number_footsteps(GEOMETRY, StepNumbers(length=0.05), GroundPlane())
    settings = FootstepsSettings(steps=tuple(steps), sway=sway)
    with pytest.raises(InfeasibleMotion, match="With sway at") as refused:
        settings.phases(GEOMETRY, MARGIN)
    other, _ = follow_advice(str(refused.value), settings, list(steps))
    assert min(sway, 1.0) < other.sway < max(sway, 1.0) or other.sway == 1.0
    assert other.phases(GEOMETRY, MARGIN)


def test_where_longer_times_alone_would_not_do_a_speed_is_named():
    law = SmoothLaw(SmoothSettings(), model(), 5e-3)
    walk = FootstepsSettings(numbers=StepNumbers(count=2), speed=20.0)
    words = r"it would be refused, too: .* At a speed of (\S+) instead of 20 it would fit\."
    with pytest.raises(InfeasibleMotion, match=words) as refused:
        law.prepare(walk)
    speed = float(re.search(words, str(refused.value))[1])
    law.prepare(replace(walk, speed=speed))
    with pytest.raises(InfeasibleMotion):
        law.prepare(replace(walk, speed=1.06 * speed))


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
