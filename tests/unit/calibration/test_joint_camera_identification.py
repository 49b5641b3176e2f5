"""Camera and geometry of a joint from made-up recordings, and what is refused of them."""

import dataclasses
import math

import numpy as np
import pytest

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import axis_from_tilt, natural_rotation
from drivers.marker_camera.projection import View
from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import find_configs, load_profile
from rig.hal.columns import Column
from rig.mechanisms.joint.calibration.camera import ROSETTE
from rig.mechanisms.joint.calibration.parameters import priors_of
from rig.mechanisms.joint.calibration.rosette import Rosette
from rig.mechanisms.joint.calibration.sighting_model import WireEnds, axes_seen
from rig.mechanisms.joint.calibration.sightings import limits_of, senses_of, track_of
from rig.runtime.log import Log

CHANNELS = ("ch1", "ch2", "ch3", "ch4")
RATE = 250.0
LATE = 3e-3
TRUE = SphericalJointGeometry(
    ball_radius=25.3e-3, ring_radius=19.8e-3, adjust_radius=25.2e-3, adjust_depth=24.9e-3,
    anchor_angles=(1.5808, 3.1316, 4.7124, 6.2832),
)  # fmt: skip
PLACE = (1.5e-3, -1.0e-3, 0.4006)


@pytest.fixture(scope="module")
def profile():
    return load_profile("joint", REGISTRY, (), find_configs())


@pytest.fixture(scope="module")
def rows(profile):
    """What is logged of a joint and a camera that are not those of the profile."""
    believed = profile.devices["camera"].settings
    real = dataclasses.replace(
        believed, position_camera_in_base=PLACE, rotation_base_from_camera=(math.pi, 0.02, -0.01)
    )
    eye, driver, wires = View(real), View(believed), ExactWires(TRUE)
    settings = profile.mechanism_settings
    # A seal that slides takes from its wire's stretch what viscous friction is believed to hold.
    lag = 0.5 * settings.friction.viscous / settings.wire_stiffness
    upright = wires.lengths(natural_rotation((0.0, 0.0, 1.0)))
    rng = np.random.default_rng(1)
    table = []
    frame, seen, stamp = -1, (0.0, 0.0, 0.0), -1.0
    for t in np.arange(0.0, ROSETTE.duration, 1.0 / RATE).tolist():
        lengths = wires.lengths(natural_rotation(ROSETTE.at(t - lag).axis))
        rods = [h - x + 1e-6 * rng.standard_normal() for h, x in zip(upright, lengths, strict=True)]
        if int(60.0 * t) > frame:  # the sample came LATE longer ago than its stamp says
            frame = int(60.0 * t)
            shown = ROSETTE.at(t - 0.04 - LATE).axis
            pixel = eye.project(TRUE.marker(shown))
            noisy = (pixel[0] + 0.05 * rng.standard_normal(), pixel[1] + 0.05 * rng.normal())
            seen = driver.meet_sphere(driver.undistort(noisy))
            stamp = t - 0.04
        table.append([1.0, t, *seen, t - stamp, *rods, *(0.0,) * 4, 0.0])
    return np.array(table)


def recording(rows, rosette=ROSETTE):
    names = (
        "phase", "reference.time", *(f"reading.marker_{axis}" for axis in "xyz"),
        "reading.marker_age", *(f"reading.rod_{name}" for name in CHANNELS),
        *(f"reading.pressure_{name}" for name in CHANNELS), "reading.age",
    )  # fmt: skip
    t, count = rows[:, 1], len(rows)
    log = Log(
        tuple(Column(name, "", "") for name in names),
        np.arange(count, dtype=np.uint64), t, rows, np.zeros(count, np.uint64), True,
    )  # fmt: skip
    return Recording([(log, rosette.segments)])


def test_wires_are_those_of_the_controllers():
    exact = ExactWires(TRUE)
    values = {name: getattr(TRUE, name) for name in ("ball_radius", "ring_radius")}
    values |= {name: getattr(TRUE, name) for name in ("adjust_radius", "adjust_depth")}
    values |= {f"anchor_angle_{k}": angle for k, angle in enumerate(TRUE.anchor_angles, 1)}
    for part in ("turned", "raised", "shift_x", "shift_y", "shift_z"):
        values |= {f"{part}_{k}": 0.0 for k in (1, 2, 3, 4)}
    wires = WireEnds.of(values)
    for tilt in (0.0, 0.3, 0.9):
        for azimuth in (0.1, 2.0, 4.4):
            axis = axis_from_tilt(tilt, azimuth)
            for twist in (0.0, 0.02):
                spin = [[math.cos(twist), -math.sin(twist), 0.0]]
                spin += [[math.sin(twist), math.cos(twist), 0.0], [0.0, 0.0, 1.0]]
                expected = exact.lengths((np.array(natural_rotation(axis)) @ spin).tolist())
                assert wires.lengths(np.array([axis]), twist)[0] == pytest.approx(
                    expected, abs=1e-12
                )


def test_a_ray_shows_the_axis_that_it_came_from(profile):
    view = View(profile.devices["camera"].settings)
    values = {p.name: p.mean for p in priors_of(profile)}
    for tilt, azimuth in ((0.0, 0.0), (0.5, 1.0), (0.7, 4.0)):
        axis = axis_from_tilt(tilt, azimuth)
        ray = view.to_camera(profile.mechanism_settings.geometry.marker(axis))
        found = axes_seen(values, np.array([ray]) / ray[2], np.array([math.pi, 0.0, 0.0]))
        assert found[0] == pytest.approx(axis, abs=1e-12)


def test_the_rosette_goes_back_as_it_came_and_its_rates_are_its_own():
    rosette, h = Rosette(tilt=0.7, petals=6, period=1.0), 1e-4
    middle = rosette.rest + rosette.one_way
    for t in np.linspace(0.1, rosette.duration - 0.1, 40).tolist():
        before, now, after = (rosette.at(t + step) for step in (-h, 0.0, h))
        slope = (np.array(after.axis) - before.axis) / (2 * h)
        bend = (np.array(after.velocity) - before.velocity) / (2 * h)
        assert slope == pytest.approx(now.velocity, abs=1e-4)
        assert bend == pytest.approx(now.acceleration, abs=2e-2)
    for ago in (0.3, 1.1, 4.0):
        there, back = rosette.at(middle - ago), rosette.at(middle + rosette.one_way - ago)
        mirrored = rosette.at(middle + ago)
        assert there.axis != pytest.approx(back.axis, abs=1e-3)
        assert mirrored.velocity != pytest.approx(there.velocity, abs=1e-3)
    assert rosette.at(0.0).axis == rosette.at(rosette.duration).axis == (0.0, 0.0, 1.0)


def test_the_camera_is_found_beside_a_wrong_geometry(profile, rows):
    (finding,) = procedures(profile)["camera"].identify(profile, recording(rows), {})
    found = {e.name: e for e in finding.estimates}
    for axis, place in zip("xyz", PLACE, strict=True):
        estimate = found[f"position.{axis}"]
        assert abs(estimate.value - place) < 3.0 * estimate.std
    assert found["latency"].value == pytest.approx(0.04 + LATE, abs=0.3e-3)
    # What a tolerance tells alone is stated as what lies anywhere within it: 95 % of 2 %.
    height = found["position.z"]
    assert 0.5 * (height.high - height.low) == pytest.approx(0.95 * 0.02 * PLACE[2], rel=0.05)
    assert np.sqrt(np.mean(finding.residuals**2)) < 8e-6
    assert finding.values["latency"].endswith(" s")
    assert len(finding.values["position_camera_in_base"]) == 3


def test_friction_turns_round_over_a_way_and_is_greater_on_a_slow_rod(profile):
    friction = dataclasses.replace(
        profile.mechanism_settings.friction, coulomb=2.0, breakaway=3.0, stribeck_velocity=8e-3
    )
    t = np.arange(0.0, 0.2, 1e-3)
    for speed, most in ((80e-3, 1.0), (0.8e-3, 1.0 + 0.5 * math.exp(-0.01))):
        rod = speed * np.where(t < 0.1, t, 0.2 - t)
        senses = senses_of(rod, limits_of(rod, t, friction), 10e-6)
        assert senses[98] == pytest.approx(most, rel=0.01)
        assert senses[-1] == pytest.approx(-most, rel=0.01)


def test_a_resting_rod_keeps_the_friction_that_it_came_with(profile, rows):
    still = rows.copy()
    still[:, 7] = np.interp(still[:, 1], [0.0, 1.0, 1.5], [5e-3, 5e-3, 9e-3])
    names = [segment.name for segment in ROSETTE.segments]
    track = track_of(profile, recording(still), names)
    assert (track.senses[track.t > 2.0, 1] > 0.9).all()


def refused(profile, rows, what):
    with pytest.raises(CalibrationRefused, match=what):
        procedures(profile)["camera"].identify(profile, recording(rows), {})


def test_a_log_that_was_cut_short_is_refused(profile, rows):
    refused(profile, rows[: len(rows) // 2], "9 of 17 stretches .* short: petal on 8")


def test_a_marker_that_is_lost_is_refused(profile, rows):
    blind = rows.copy()
    gone = (blind[:, 1] > 5.0) & (blind[:, 1] < 7.0)
    blind[gone, 5] = blind[gone, 1] - 5.0  # the newest frame is the one from then
    refused(profile, blind, r"saw the marker in \d+ frames of 'petal on \d'.* is it lit")


def test_a_rod_that_is_stuck_is_refused(profile, rows):
    still = rows.copy()
    still[:, 8] = 1e-3 * np.sin(still[:, 1])
    refused(profile, still, r"the rod of ch3 moved by 2 mm, at least 10 mm .*stuck")


def test_a_rod_whose_zero_is_wrong_is_refused(profile, rows):
    off = rows.copy()
    off[:, 7] += 3e-3
    refused(profile, off, r"the rod of ch\d seems to be off by .* calibrate its encoder first")


def test_geometry_wants_the_height_of_the_marker(profile, rows):
    geometry = procedures(profile)["geometry"]
    with pytest.raises(CalibrationRefused, match="height gauge was not read in 'upright'"):
        geometry.identify(profile, recording(rows), {})
    shown = {"height gauge": {"upright": 77.6e-3}}
    with pytest.raises(CalibrationRefused, match=r"shows 77.600 mm .* set to zero"):
        geometry.identify(profile, recording(rows), shown)


def test_what_is_recorded_is_not_recorded_again(profile):
    camera = procedures(profile)["camera"]
    names = [segment.name for segment in ROSETTE.segments]
    assert camera.excite(profile, names).motion.segments == ()
    again = camera.excite(profile, names[:5])
    assert [s.name for s in again.motion.segments if s.name != "all"] == names
    assert any("limits.disagreement is 59.4 mm" in note for note in again.notes)
