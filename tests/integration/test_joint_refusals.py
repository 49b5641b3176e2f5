"""What the joint must not do is refused before anything is opened, with number and pose."""

import random
from pathlib import Path

import pytest

from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError, MotionRefused

CONFIGS = Path(__file__).parents[2] / "configs"
GEOMETRY = "joint.geometry"
LIMITS = "joint.limits"


def plan(*options):
    return load_plan(
        "joint-ideal-circle",
        ["reference.tones=[{frequency: 0.2 Hz, laps: 1}]", "metrics={}", *options],
        configs=CONFIGS,
    )


REFUSED = {
    "pressure-too-low-for-the-wires": (
        (f"joint.base_pressure={random.Random(18).uniform(0.1, 20.0):.3f} kPa",),
        ("base_pressure (", "which is not between least_tension (5 N) and most_tension (90 N)"),
    ),
    "eq-17": (
        (f"{GEOMETRY}.ring_radius=17 mm", f"{LIMITS}.tilt=90 deg"),
        ("max_tilt (90.00 deg) must be below 87.84 deg", "Eq. (17)", "upsilon is 44."),
    ),
    "eq-17-in-general": (
        (
            f"{GEOMETRY}.ring_radius=14 mm",
            f"{GEOMETRY}.adjust_radius=21 mm",
            f"{GEOMETRY}.adjust_depth=40 mm",
            f"{LIMITS}.tilt=63 deg",
        ),
        ("max_tilt (63.00 deg) must be below 61.7", "opposite its adjust point"),
    ),
    "tilt-limit": (
        ("reference.tilt=61 deg",),
        ("after 0.00 s", "at 61.00 deg tilt towards 0.0 deg", "max_tilt is 60.00 deg"),
    ),
    "stroke": (
        ("reference.tilt=40 deg", "joint.home=12 mm", "plant.home=12 mm"),
        ("at 40.00 deg tilt towards", "rod 4 would extend to -5.45 mm, beyond 0.00 mm"),
    ),
    "stroke-of-a-larger-ball": (
        (
            "reference.tilt=50 deg",
            f"{GEOMETRY}.ball_radius=40 mm",
            f"{GEOMETRY}.ring_radius=32 mm",
            f"{GEOMETRY}.adjust_radius=40 mm",
            f"{GEOMETRY}.adjust_depth=40 mm",
        ),
        ("at 50.00 deg tilt", "rod 2 would extend to 64.91 mm, beyond 60.00 mm"),
    ),
    "wire-leaves-the-ball": (
        ("reference.tilt=30 deg", f"{GEOMETRY}.ring_radius=22 mm", f"{LIMITS}.free_wires=false"),
        ("at 30.00 deg tilt towards", "wire 4 leaves the ball", "from 28.36 deg of tilt"),
    ),
    "wire-slack": (
        (
            "reference.tilt=68 deg",
            f"{GEOMETRY}.ring_radius=18 mm",
            f"{LIMITS}.tilt=75 deg",
        ),
        ("at 68.00 deg tilt towards", "wire 4 would bear", "no pull holds this pose"),
    ),
    "ring-unseated": (
        (
            "reference.tilt=74.5 deg",
            f"{GEOMETRY}.ring_radius=23.5 mm",
            f"{LIMITS}.tilt=79 deg",
            f"{LIMITS}.tension=[5 N, 400 N]",
            "joint.home=40 mm",
            "joint.stroke=80 mm",
            "plant.home=40 mm",
            "plant.cylinder.stroke=80 mm",
            *(f"devices.encoder-{k}.stroke=80 mm" for k in (1, 2, 3, 4)),
        ),
        ("at 74.50 deg tilt towards", "leaves its seat", "inside its contact cone"),
    ),
    "too-much-tension": (
        ("reference.tilt=58 deg", f"{LIMITS}.tension=[18 N, 60 N]"),
        ("at 58.00 deg tilt towards", "keeps 18 N", "most_tension is 60 N"),
    ),
}


@pytest.mark.parametrize(("options", "words"), REFUSED.values(), ids=REFUSED)
def test_motion_is_refused_with_number_and_pose(options, words):
    with pytest.raises(MotionRefused) as caught:
        plan(*options)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "options",
    [
        ("reference.tilt=60 deg",),
        ("reference.tilt=28 deg", f"{GEOMETRY}.ring_radius=22 mm", f"{LIMITS}.free_wires=false"),
        ("reference.tilt=60 deg", f"{GEOMETRY}.ring_radius=18 mm"),
        (f"{GEOMETRY}.ring_radius=18 mm", f"{LIMITS}.tilt=90 deg"),  # just meets eq. (17)
    ],
)
def test_motion_just_within_its_bounds_is_planned(options):
    assert plan(*options).motion.duration > 5.0


def test_marker_and_camera_must_mean_the_same_sphere():
    with pytest.raises(ConfigurationError) as caught:
        plan(f"{GEOMETRY}.marker_height=60 mm")
    for word in ("camera", "sphere_radius is 52.628 mm", "marker_height is 60.000 mm", "0.2 mm"):
        assert word in str(caught.value)


def test_refusal_is_told_in_the_terminal_with_exit_code_2(tmp_path, capsys):
    arguments = ["joint-ideal-circle", "--configs", str(CONFIGS), "--out", str(tmp_path)]
    code = invoke(["run", *arguments, "--set", "reference.tilt=61 deg"])
    told = capsys.readouterr().err
    assert code == 2
    assert "at 61.00 deg tilt towards" in told
    assert "max_tilt is 60.00 deg" in told
    assert not list(tmp_path.iterdir())
