"""The renderer against hand calculation: it must be right on its own to judge the detector."""

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import QUIET, H, pose, small

from drivers.sim.camera import renderer
from drivers.sim.camera.poses import MarkerPose
from drivers.sim.camera.renderer import MarkerRenderer, marker_cells
from drivers.sim.camera.settings import CameraSimulationSettings

FLAT = replace(QUIET, background=40.0)
SCENE, BRIGHT = 40.0, 200.0


def coverage(image):
    return (image.astype(float) - SCENE) / (BRIGHT - SCENE)


def centroid(image):
    share = coverage(image)
    rows, columns = np.mgrid[: share.shape[0], : share.shape[1]]
    return (share * columns).sum() / share.sum(), (share * rows).sum() / share.sum()


@pytest.fixture(scope="module")
def flat():
    return MarkerRenderer(small(), FLAT, 1)


def test_disc_at_home_is_where_and_as_large_as_the_pinhole_says(flat):
    image = flat.render([pose(0.0)])
    radius = 3333 * 3e-3 / (0.4 - H)
    assert centroid(image) == pytest.approx((255.5, 255.5), abs=1e-3)
    assert coverage(image).sum() == pytest.approx(math.pi * radius**2, rel=2e-3)


def test_displaced_disc_is_displaced_as_the_pinhole_says(flat):
    flat_disc = MarkerPose((5e-3, -8e-3, 0.05), np.eye(3))  # parallel to the image: no shift
    u, v = centroid(flat.render([flat_disc]))
    assert u == pytest.approx(255.5 + 3333 * 5e-3 / 0.35, abs=2e-3)
    assert v == pytest.approx(255.5 + 3333 * 8e-3 / 0.35, abs=2e-3)


def test_edge_is_blurred_by_the_point_spread(flat):
    row = coverage(flat.render([pose(0.0)]))[255]
    edge = 255.5 + 3333 * 3e-3 / (0.4 - H)
    sigma = math.sqrt(0.9**2 + 1 / 12)
    for column in range(int(edge) - 3, int(edge) + 5):
        expected = 0.5 * math.erfc((column - edge) / (sigma * math.sqrt(2)))
        assert row[column] == pytest.approx(expected, abs=0.02)


def test_tilt_foreshortens(flat):
    share = coverage(flat.render([pose(math.radians(20.0), 0.0)]))
    wide, high = (share > 0.5).any(axis=0).sum(), (share > 0.5).any(axis=1).sum()
    # The line of sight to a marker at 20 degrees leans by another 3.
    assert wide / high == pytest.approx(math.cos(math.radians(23.0)), abs=0.04)


def test_exposure_averages_the_poses(flat):
    def at(x):
        return MarkerPose((x, 0.0, 0.05), np.eye(3))

    still, moving = flat.render([at(0.0)]), flat.render([at(-3e-3), at(3e-3)])
    assert centroid(moving) == pytest.approx(centroid(still), abs=5e-3)
    assert coverage(moving).sum() == pytest.approx(coverage(still).sum(), rel=1e-3)
    # Half a disc's width apart to either side, they do not overlap: half the light each.
    assert coverage(moving).max() == pytest.approx(0.5, abs=0.01)


def test_noise_is_that_of_the_sensor():
    optics = replace(FLAT, read_noise=2.0, shot_noise=0.1)
    image = MarkerRenderer(small(), optics, 1).render([pose(0.0)]).astype(float)
    far, disc = image[:200, :200], image[240:270, 240:270]
    rounding = 1 / 12
    assert far.mean() == pytest.approx(SCENE, abs=0.05)
    assert far.var() == pytest.approx(4.0 + 0.1 * SCENE + rounding, rel=0.05)
    assert disc.var() == pytest.approx(4.0 + 0.1 * BRIGHT + rounding, rel=0.15)


def test_equal_seeds_give_equal_images():
    def images(seed):
        renderer = MarkerRenderer(small(), CameraSimulationSettings(), seed)
        return [renderer.render([pose(0.1 * k)]) for k in range(3)]

    first, second, other = images(3), images(3), images(4)
    assert all((a == b).all() for a, b in zip(first, second, strict=True))
    assert not (first[0] == other[0]).all()


def test_frames_in_a_row_differ_in_their_noise():
    renderer = MarkerRenderer(small(), CameraSimulationSettings(), 1)
    assert not (renderer.render([pose(0.1)]) == renderer.render([pose(0.1)])).all()


@pytest.mark.parametrize("count", np.random.default_rng(61).integers(1, 9, 2))
def test_what_one_camera_saw_changes_no_other(count):
    """They share what they see without a marker."""
    first = MarkerRenderer(small(), CameraSimulationSettings(), 3)
    seen = [first.render([pose(0.01 * k)]) for k in range(count)]
    for image in seen:
        image[:] = 0
    later = MarkerRenderer(small(), CameraSimulationSettings(), 3)
    renderer._make_backdrop.cache_clear()
    alone = MarkerRenderer(small(), CameraSimulationSettings(), 3)
    for k in range(count):
        assert (later.render([pose(0.01 * k)]) == alone.render([pose(0.01 * k)])).all()
    assert (later.render(()) == alone.render(())).all()


@pytest.mark.parametrize(
    "item",
    [
        MarkerPose((0.2, 0.0, 0.05), np.eye(3)),
        MarkerPose((0.0, -0.2, 0.05), np.eye(3)),
        MarkerPose((0.0, 0.0, 0.5), np.eye(3)),
        MarkerPose((0.0, 0.0, H), np.diag([1.0, -1.0, -1.0])),
    ],
    ids=["right of the view", "below the view", "behind the lens", "turned away"],
)
def test_marker_out_of_sight_leaves_the_scene(flat, item):
    assert (flat.render([item]) == SCENE).all()


def test_marker_at_the_border_is_cut(flat):
    image = flat.render([MarkerPose((0.35 * 256 / 3333, 0.0, 0.05), np.eye(3))])
    assert coverage(image).sum() == pytest.approx(math.pi * (3333 * 3e-3 / 0.35) ** 2 / 2, rel=0.02)


def test_covered_lens_is_dark(flat):
    assert flat.render_darkness().mean() < 3.0


def test_pose_error_moves_the_image():
    optics = replace(FLAT, position_error=(1e-3, 0.0, 0.0))
    image = MarkerRenderer(small(), optics, 1).render([pose(0.0)])
    assert centroid(image)[0] == pytest.approx(255.5 - 3333 * 1e-3 / (0.4 - H), abs=5e-3)


def test_square_marker_shows_its_cells():
    settings = small(kind="aruco")
    image = MarkerRenderer(settings, QUIET, 1).render([pose(0.0)])
    cells = marker_cells("4x4_50", 0)
    pixels = 3333 * (8e-3 / 6) / (0.4 - H)
    for row in range(8):
        for column in range(8):
            u, v = (255.5 + (at - 3.5) * pixels for at in (column, row))
            assert (image[round(v), round(u)] > 110) == bool(cells[row, column])
