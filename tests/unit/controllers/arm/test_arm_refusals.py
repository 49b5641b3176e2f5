"""What cannot be done is refused with its number, whatever the arm; what the number says can be."""

import dataclasses
import math
import re

import pytest
from arm_cases import GEOMETRIES, START_FIG4, radians

from controllers.arm.dwell import elbow_at_depth
from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.kinematics import dimensions_of
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.paths import DwellLine, Line, TurnBack
from controllers.arm.plain import Inverse, InverseSettings
from controllers.arm.turn_path import TurnPath
from controllers.motion import InfeasibleMotion

PERIOD = 2e-2
LAWS = {"paper": (EscPaper, EscPaperSettings()), "ours": (Esc, EscSettings())}
WIDE = {"position_min": (-30.0,) * 6, "position_max": (30.0,) * 6}

each_law = pytest.mark.parametrize("law", LAWS)
each_arm = pytest.mark.parametrize(
    "geometry",
    [
        GEOMETRIES["paper"],
        GEOMETRIES["offsets"],  # links of two lengths, the other sign of the wrist
        pytest.param(GEOMETRIES["other wrist"], marks=pytest.mark.slow),
        pytest.param(GEOMETRIES["equal links"], marks=pytest.mark.slow),
    ],
    ids=("paper", "offsets", "other wrist", "equal links"),
)


def plan(law, geometry, path, **limits):
    kind, settings = LAWS[law]
    return kind(settings, dataclasses.replace(geometry, **limits), PERIOD).prepare(path)


def refusal(law, geometry, path, **limits):
    with pytest.raises(InfeasibleMotion) as refused:
        plan(law, geometry, path, **limits)
    return str(refused.value)


def number(pattern, message):
    found = re.search(pattern, message)
    assert found, f"{pattern!r} is not in {message!r}"
    return float(found.group(1))


def elbow_at(geometry, angle):
    """Return Fig. 4's start with the elbow's angle, the forearm's offset included, at `angle`."""
    q1, q2, _, q4, q5, q6 = START_FIG4
    return (q1, q2, angle - geometry.elbow_angle, q4, q5, q6)


@each_law
@each_arm
@pytest.mark.parametrize("angle", [115.0, 70.0])
def test_speed_without_a_region_names_the_least_joint_rate_that_would_do(law, geometry, angle):
    path = TurnBack(start=elbow_at(geometry, math.radians(angle)), speed=0.7, turn_rate=0.0)
    # Where accelerations ask for as wide a region, no rate would do, and none is named.
    message = refusal(law, geometry, path, acceleration_limits=(1e6,) * 6)
    # Beside the shoulder's axis the wrist leaves the shoulder faster than the hand goes.
    steeper = math.hypot(1.0, geometry.shoulder_offset / geometry.reach)
    assert number(r"sin q_s = (\d\.\d+), more than 1", message) == pytest.approx(
        1.5 * geometry.reach * steeper * 0.7 / (geometry.a2 * geometry.forearm), abs=1e-4
    )
    least = number(r"at least (\d+\.\d+) rad/s", message)
    # In time for the other joints, and without limits of accelerations that would ask for more.
    limits = [1e3] * 6
    free = {"acceleration_limits": (1e6,) * 6, **WIDE}
    limits[2] = 0.999 * least
    assert "q_s" in refusal(law, geometry, path, rate_limits=tuple(limits), **free)
    limits[2] = least
    assert plan(law, geometry, path, rate_limits=tuple(limits), **free).crossings


@each_law
@each_arm
def test_speed_that_the_message_names_has_a_region(law, geometry):
    path = TurnBack(speed=0.7, turn_rate=0.0)
    slower = number(r"no faster than (\d\.\d+) m/s", refusal(law, geometry, path))
    assert plan(law, geometry, dataclasses.replace(path, speed=0.99 * slower), **WIDE).crossings


@each_arm
def test_dwell_that_would_stop_names_the_longest_one(geometry):
    path = DwellLine(dwell=8.0)
    message = refusal("paper", geometry, path)
    longest = number(r"dwells at most (\d\.\d+) s", message)
    assert number(r"b reaches (-\d\.\d+)", message) < 0.0
    assert "stop and reverse" in refusal(
        "paper", geometry, dataclasses.replace(path, dwell=longest + 1e-3)
    )
    done = plan("paper", geometry, dataclasses.replace(path, dwell=longest - 1e-3))
    assert len(done.crossings) == 1
    assert plan("ours", geometry, path).marks["region"], "a ramp dwells as long as is asked for"


@each_law
@each_arm
def test_line_that_does_not_meet_the_boundary_names_reach_and_way(law, geometry):
    message = refusal(law, geometry, TurnBack(travel=0.1))
    assert f"{geometry.reach:g} m from the shoulder, within 0.1 m" in message


@each_law
@each_arm
def test_start_in_the_region_names_both_sines(law, geometry):
    message = refusal(law, geometry, TurnBack(start=elbow_at(geometry, math.radians(20.0))))
    assert number(r"\|S3\| = (\d\.\d+)", message) == pytest.approx(0.3420, abs=1e-4)
    assert number(r"sin q_s = (\d\.\d+)", message) > 0.3420


@each_law
@each_arm
def test_start_in_the_region_of_a_dwell_names_both_depths(law, geometry):
    arm = dimensions_of(geometry)
    path = DwellLine(start=elbow_at(geometry, 0.5 * elbow_at_depth(arm, 0.03)))
    message = refusal(law, geometry, path)
    assert number(r"wrist is (\d\.\d+) m from the boundary", message) < 0.03
    assert "the region is 0.0300 m deep" in message


@each_law
@each_arm
def test_tangential_command_at_the_singularity_names_the_radial_share(law, geometry):
    start = (0.0, 0.5 * math.pi, -geometry.elbow_angle, *radians(30, -50, 0))
    path = TurnBack(start=start, direction=(0.0, 0.0, 1.0), turn_rate=0.0)
    message = refusal(law, geometry, path)
    assert number(r"radial share is ([\d.e-]+)\)", message) < 1e-3
    assert "S3 = " in message


@each_law
@each_arm
def test_joint_limit_in_the_path_names_joint_time_and_angle(law, geometry):
    free = plan(law, geometry, TurnBack())
    lower = (*geometry.position_min[:2], -0.5, *geometry.position_min[3:])
    message = refusal(law, geometry, TurnBack(), position_min=lower)
    first = free.t[free.positions[:, 2] < -0.5][0]
    assert number(r"after (\d+\.\d+) s q3 would be at", message) == pytest.approx(first, abs=1e-3)
    assert number(r"would be at (-2\d\.\d+) deg", message) < math.degrees(-0.5)
    assert "its range of -28.65 to 160.43 deg" in message


BENT = (0.3, 0.4, 1.1, 0.2, 0.8, 0.1)


@pytest.mark.parametrize(
    ("path", "said"),
    [
        (Line(BENT, before=1e-9, after=1e-9), "the path is 2e-09 m long; less than 1e-06 m is"),
        (TurnPath(BENT, (1.0, 0.0, 0.0), angle=1e-9), "the path is a turn by 1e-09 rad; less"),
    ],
    ids=("line", "turn"),
)
@pytest.mark.parametrize("kind", ["look-ahead", "inverse", "esc"])
def test_a_path_of_a_nanometre_is_none(path, said, kind):
    law = {
        "look-ahead": LookAhead(LookAheadSettings(), GEOMETRIES["paper"], 5e-3),
        "inverse": Inverse(InverseSettings(), GEOMETRIES["paper"], 5e-3),
        "esc": Esc(EscSettings(), GEOMETRIES["paper"], 5e-3),
    }[kind]
    with pytest.raises(InfeasibleMotion, match=re.escape(said)):
        law.prepare(path)
