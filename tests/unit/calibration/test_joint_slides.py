"""Slides of a joint's pairs that nobody leads: how hard they are pushed, and when let go."""

import math
from itertools import pairwise

import pytest
from pneumatic_rigs import pneumatics_of

from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.types import JointCommand, JointEstimate, JointState
from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.config import find_configs, load_profile
from rig.mechanisms.joint.calibration.slide_script import SlideScript
from rig.mechanisms.joint.calibration.slides import GOAL, Release, Slides
from rig.mechanisms.joint.calibration.tugs import StrokesAndTugs

PERIOD = 1e-3
SLIDES = Slides(65e3, 250e3, 60.0, count=3)
GEOMETRY = SphericalJointGeometry()


class Pair:
    """A pair that breaks away under a force and slides at a speed until late air lets it go."""

    def __init__(self, breakaway, late):
        self.breakaway, self.late = breakaway, late
        self.place, self.felt, self.slides = 0.0, [], False

    def push(self, force):
        self.felt.append(force)
        feels = self.felt[max(len(self.felt) - 1 - round(self.late / PERIOD), 0)]
        self.slides = abs(feels) >= (0.7 if self.slides else 1.0) * self.breakaway
        if self.slides:
            self.place += math.copysign(0.08 * PERIOD, feels)


class Followed:
    """A controller that pushes two pairs, and notes the references."""

    def __init__(self, *pairs):
        self.pairs, self.asked = pairs, []

    @property
    def estimate(self):
        leans = [pair.place / GEOMETRY.ball_radius for pair in self.pairs]
        x, y = leans[1], leans[0]  # the first pair's anchors lie along Y
        upright = math.sqrt(1.0 - x * x - y * y)
        marker = (x, y, upright)
        return JointEstimate(marker, marker, 0.0, (0.0,) * 4, (0.0,) * 4)

    def reset(self, state):
        pass

    def update(self, state, reference):
        self.asked.append(reference)
        for pair, force in zip(self.pairs, reference.push, strict=True):
            pair.push(force)
        return JointCommand(0.0, 0.0, 0.0, 0.0)


def played(*pairs, rounds=0):
    """Return the cycles of a script: time, places of both pairs, and what was asked for."""
    follower = Followed(*pairs)
    settings = StrokesAndTugs(SLIDES, rounds=rounds, most=40.0, move=4.0)
    script = SlideScript(
        settings, None, follower, 91e3, 65e3,
        slides=SLIDES, geometry=GEOMETRY, least=9.75, area=181e-6, stiffness=80e3,
    )  # fmt: skip
    cycles = []
    for cycle in range(int(settings.duration / PERIOD)):
        t = cycle * PERIOD
        a, b = (pair.place for pair in pairs)
        script.update(JointState(t, (a, -b, -a, b), (0.0,) * 4), script.at(t))
        cycles.append((t, a, b, follower.asked[-1]))
    return settings, cycles


def at(cycles, t):
    return cycles[min(round(t / PERIOD), len(cycles) - 1)]


@pytest.mark.parametrize("breakaway", [8.0, 20.0, 45.0])
@pytest.mark.parametrize("late", [0.02, 0.06])
def test_slides_go_to_and_fro_about_upright_however_much_it_sticks(breakaway, late):
    _, cycles = played(Pair(breakaway, late), Pair(breakaway, late))
    ends = [[], []]
    for slide in SLIDES.slides:
        ends[slide.pair].append(at(cycles, slide.end - PERIOD)[1 + slide.pair])
    for mine in ends:
        assert all(one * other < 0.0 for one, other in pairwise(mine))
        assert [abs(place) for place in mine[2:]] == pytest.approx([GOAL] * 4, abs=1e-3)


def test_only_the_pair_that_slides_is_pushed_and_the_other_one_is_balanced_where_it_stands():
    _, cycles = played(Pair(20.0, 0.04), Pair(20.0, 0.04))
    for slide in SLIDES.slides[2:]:
        _, a, b, reference = at(cycles, slide.rise + 0.1)
        other = (b, a)[slide.pair] / GEOMETRY.ball_radius
        assert reference.push[1 - slide.pair] == 0.0 < abs(reference.push[slide.pair])
        x, y, _ = reference.axis
        assert (x, y)[slide.pair] == pytest.approx(other, abs=1e-9)
        assert (y, x)[slide.pair] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("breakaway", "second"), [(4.0, 70e3), (20.0, 132e3), (58.0, 250e3)])
def test_the_second_base_pressure_follows_from_what_broke_the_pairs_away(breakaway, second):
    _, cycles = played(Pair(breakaway, 0.02), Pair(breakaway, 0.02))
    bases = {at(cycles, slide.rise)[3].base_pressure for slide in SLIDES.slides if slide.again}
    assert len(bases) == 1
    assert bases.pop() == pytest.approx(second, rel=0.03)


def test_the_ring_is_near_upright_before_each_tug():
    settings, cycles = played(Pair(20.0, 0.04), Pair(20.0, 0.04), rounds=1)
    for tug in settings.tugs:
        assert [abs(place) for place in at(cycles, tug.rise)[1:3]] < [1.5e-3, 1.5e-3]
        assert at(cycles, tug.rise + 0.2)[3].push[tug.pair] == pytest.approx(
            tug.side * 4.0, abs=0.1
        )


def test_what_is_let_go_is_pushed_back_by_less_than_breaks_it_away():
    release = Release(-3e-3, 0.05, 3e-3, 0.85)
    assert release.side == 1.0
    assert release.force(0.0, -3e-3, 12.0, 0.5e-3) == 12.0
    assert release.force(0.01, -2.4e-3, 13.0, 0.5e-3) == pytest.approx(0.85 * 13.0)
    assert release.force(0.02, -1.8e-3, 14.0, 0.5e-3) == pytest.approx(0.85 * 13.0)
    # 60 mm/s for 50 ms: 3 mm more.
    assert release.force(0.06, 0.6e-3, 18.0, 0.5e-3) == pytest.approx(-0.5 * 13.0)
    assert release.broke == 13.0
    assert release.let_go == 0.6e-3
    assert release.late(3.6e-3) == pytest.approx(0.05, abs=2e-3)


def test_a_pair_that_never_moves_is_pushed_no_harder_than_permitted():
    _, cycles = played(Pair(99.0, 0.02), Pair(99.0, 0.02))
    assert max(max(map(abs, row[3].push)) for row in cycles) == 60.0


@pytest.mark.parametrize(
    ("rig", "options", "alone"),
    [
        ("joint", (), True),
        ("joint", ("joint.regulator_response={dead_time: 11 ms, monitor_time: 5 ms}",), False),
        ("joint", ("joint.friction.breakaway=6.5 N",), False),  # seals that do not hold it
        ("joint-ideal", (), False),
        ("joint-valves", (), False),
    ],
)
def test_nobody_leads_a_ring_that_sticks_behind_late_air(rig, options, alone):
    profile = load_profile(rig, REGISTRY, options, find_configs())
    assert pneumatics_of(profile).nobody_leads is alone
    excitation = procedures(profile)["friction"].excite(profile, ())
    assert isinstance(excitation.settings.strokes, Slides) is alone
    assert any("no controller leads the ring" in line for line in excitation.describe()) is alone
