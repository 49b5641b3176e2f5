"""The detector's geometry against hand calculation, brute force, OpenCV and the renderer's own."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_scenes import BENT, STRAIGHT, H, pose, random_poses, small
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.marker_camera.projection import View, rotation_from_vector
from drivers.marker_camera.settings import MarkerCameraSettings, MarkerSettings
from drivers.sim.camera.kernels import trace_rays
from drivers.sim.camera.poses import rotation_matrix, twist_of

DOWN = small()  # at 0.4 m, looking straight down
TILTED = replace(
    small(BENT),
    rotation_base_from_camera=(2.9, 0.2, -0.15),
    position_camera_in_base=(0.03, -0.05, 0.38),
)


def test_pinhole_by_hand():
    # 0.35 m below the lens, 10 mm to the right and 20 mm to the back of the base frame: the
    # camera is turned over about x, so that the back is up in the image.
    u, v = View(DOWN).project((0.01, 0.02, 0.05))
    assert u == pytest.approx(255.5 + 3333 * 0.01 / 0.35, abs=1e-9)
    assert v == pytest.approx(255.5 - 3333 * 0.02 / 0.35, abs=1e-9)


def test_marker_at_home_is_at_the_principal_point():
    assert View(DOWN).project((0.0, 0.0, H)) == pytest.approx((255.5, 255.5), abs=1e-9)


def test_distortion_by_hand():
    lens = replace(STRAIGHT, k1=-0.2, k2=0.3, k3=0.4, p1=0.001, p2=-0.002)
    x, y = 0.1, -0.05  # normalised; r2 = 0.0125
    radial = 1 - 0.2 * 0.0125 + 0.3 * 0.0125**2 + 0.4 * 0.0125**3
    u = x * radial + 2 * 0.001 * x * y - 0.002 * (0.0125 + 2 * x * x)
    v = y * radial + 0.001 * (0.0125 + 2 * y * y) + 2 * -0.002 * x * y
    view = View(small(lens))
    at = (0.35 * x, -0.35 * y, 0.05)
    assert view.project(at) == pytest.approx((255.5 + 3333 * u, 255.5 + 3333 * v), abs=1e-9)


@pytest.mark.parametrize("settings_", [DOWN, TILTED], ids=["straight", "bent"])
def test_projection_agrees_with_opencv(settings_):
    points = np.array([item.position for item in random_poses(50, 1.0)])
    lens = settings_.intrinsics
    base_from_camera = cv2.Rodrigues(np.array(settings_.rotation_base_from_camera))[0]
    camera = np.array(settings_.position_camera_in_base)
    expected, _ = cv2.projectPoints(
        points,
        cv2.Rodrigues(base_from_camera.T)[0],
        -base_from_camera.T @ camera,
        np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]]),
        np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3]),
    )
    view = View(settings_)
    seen = np.array([view.project(tuple(point)) for point in points])
    assert np.abs(seen - expected.reshape(-1, 2)).max() < 1e-8


def test_renderers_rays_agree_with_the_detectors_lens():
    view = View(TILTED)
    rays = np.empty((512, 512, 2), np.float32)
    lens = TILTED.intrinsics
    trace_rays(
        rays,
        np.array([lens.fx, lens.fy]),
        np.array([lens.cx, lens.cy]),
        np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3]),
    )
    for row in range(0, 512, 73):
        for column in range(0, 512, 73):
            assert rays[row, column] == pytest.approx(view.undistort((column, row)), abs=2e-8)


@given(
    u=st.floats(0, 511),
    v=st.floats(0, 511),
    k1=st.floats(-0.5, 0.5),
    p1=st.floats(-5e-3, 5e-3),
)
@settings(max_examples=100, deadline=None)
def test_undistorting_inverts_distorting(u, v, k1, p1):
    view = View(small(replace(BENT, k1=k1, p1=p1)))
    x, y = view.undistort((u, v))
    assert view.project((0.4 * x, -0.4 * y, 0.0)) == pytest.approx((u, v), abs=1e-6)


@pytest.mark.parametrize("vector", [(0, 0, 0), (math.pi, 0, 0), (0.3, -1.2, 2.0), (1e-9, 0, 0)])
def test_both_sides_compute_the_same_rotation(vector):
    assert np.allclose(rotation_from_vector(vector), rotation_matrix(vector), atol=1e-12)
    assert np.allclose(rotation_matrix(vector), cv2.Rodrigues(np.array(vector, float))[0])


# The sphere ---------------------------------------------------------------------------


@pytest.mark.parametrize("settings_", [DOWN, TILTED], ids=["straight", "bent"])
def test_ray_through_a_projected_marker_finds_it(settings_):
    view = View(settings_)
    for item in random_poses(100, 1.2):
        position = tuple(item.position)
        found = view.meet_sphere(view.undistort(view.project(position)))
        assert math.dist(found, position) < 1e-11


def test_nearer_of_two_intersections_is_taken():
    x, y, z = View(DOWN).meet_sphere((0.05, 0.0))
    assert z > 0
    assert math.hypot(x, y, z) == pytest.approx(H, abs=1e-15)


def test_ray_beside_the_sphere_meets_nothing():
    edge = math.tan(math.asin(H / 0.4))
    assert View(DOWN).meet_sphere((edge * 0.999, 0.0)) is not None
    assert View(DOWN).meet_sphere((edge * 1.001, 0.0)) is None


def rim(view, item, radius, count=20000):
    """The normalised image of a disc's rim."""
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    axes = np.asarray(item.rotation)
    points = (
        np.asarray(item.position)[:, None]
        + radius * axes[:, :1] * np.cos(angles)
        + radius * axes[:, 1:2] * np.sin(angles)
    )
    seen = np.array([view.to_camera(tuple(point)) for point in points.T])
    return seen[:, :2] / seen[:, 2:]


def polygon(points):
    """Area and centroid of a polygon."""
    a, b = points, np.roll(points, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
    area = cross.sum() / 2
    return abs(area), ((a + b) * cross[:, None]).sum(axis=0) / (6 * area)


@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.8])
def test_centroid_of_a_discs_image_against_brute_force(tilt):
    view = View(TILTED)
    item = pose(tilt, 0.7)
    outline = rim(view, item, 3e-3)
    area, centroid = polygon(outline)
    x, y, z = view.to_camera(tuple(item.position))
    shift = view.disc_centre_shift(tuple(item.position), 3e-3)
    assert shift == pytest.approx((centroid[0] - x / z, centroid[1] - y / z), abs=1e-10)
    lens = TILTED.intrinsics
    assert view.disc_area(tuple(item.position), 3e-3) == pytest.approx(
        area * lens.fx * lens.fy, rel=1e-3
    )


def test_disc_centre_shift_is_what_locating_takes_off():
    view = View(DOWN)
    item = pose(0.35, 0.4)
    _, (x, y) = polygon(rim(view, item, 3e-3))
    pixel = (255.5 + 3333 * x, 255.5 + 3333 * y)
    assert math.dist(view.locate_disc(pixel, 3e-3), item.position) < 1e-9
    ignored = math.dist(view.meet_sphere((x, y)), item.position)
    assert 3e-6 < ignored < 20e-6


def test_disc_that_turns_its_back_has_no_area():
    assert View(DOWN).disc_area((0.0, 0.0, -H), 3e-3) == 0.0


# Twist --------------------------------------------------------------------------------


@pytest.mark.parametrize("tilt", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("twist", [-2.0, 0.0, 0.03, 1.0])
def test_twist_of_four_corners(tilt, twist):
    view = View(TILTED)
    item = pose(tilt, 2.1, twist)
    corners = []
    for sx, sy in ((-1, 1), (1, 1), (1, -1), (-1, -1)):
        x, y, z = view.to_camera(
            tuple(item.position + 4e-3 * item.rotation @ np.array([sx, sy, 0.0]))
        )
        corners.append((x / z, y / z))
    assert view.twist(tuple(item.position), corners) == pytest.approx(twist, abs=1e-9)
    assert twist_of(item.rotation) == pytest.approx(twist, abs=1e-12)


def test_upside_down_has_no_twist():
    assert View(DOWN).twist((0.0, 0.0, -H), [(0.0, 0.0)] * 4) is None


# Settings -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"position_camera_in_base": (0.0, 0.0, 0.05)}, "inside the marker's sphere"),
        ({"roi": 64}, "too small for a marker"),
        ({"exposure": 0.02}, "longer than one frame"),
        ({"max_age": 0.05}, "every reading would be too old"),
    ],
)
def test_settings_that_contradict_each_other(change, words):
    with pytest.raises(ValueError, match=words):
        MarkerCameraSettings(**change)


def test_region_must_hold_a_square_marker():
    with pytest.raises(ValueError, match="too small"):
        MarkerCameraSettings(marker=MarkerSettings(kind="aruco", side=20e-3))
