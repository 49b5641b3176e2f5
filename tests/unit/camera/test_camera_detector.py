"""The detector on rendered frames: precision, tracking, and what it says when it cannot see."""

import math
import multiprocessing

import cv2
import numpy as np
import pytest
from camera_scenes import (
    BENT,
    STRAIGHT,
    H,
    pose,
    random_poses,
    render_all,
    rms,
    small,
)
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from drivers.marker_camera.blob import compute_histogram, find_largest_blob, split_levels
from drivers.marker_camera.detector import MarkerDetector
from drivers.marker_camera.device import explain
from drivers.marker_camera.projection import View
from drivers.marker_camera.settings import IntrinsicsSettings, MarkerCameraSettings, MarkerSettings
from drivers.marker_camera.sighting import Sight, Sighting, decode_sighting, encode_sighting
from drivers.sim.camera.poses import MarkerPose, twist_of
from drivers.sim.camera.renderer import MarkerRenderer
from drivers.sim.camera.settings import CameraSimulationSettings

REAL = CameraSimulationSettings()
WIDE = math.radians(25.0)


def detect_all(settings, images):
    detector = MarkerDetector(settings)
    return [detector.detect(image, k, k / 60) for k, image in enumerate(images)]


def errors_of(sightings, poses):
    assert all(item.sight is Sight.SEEN for item in sightings)
    return np.array(
        [np.subtract(s.positions[0], p.position) for s, p in zip(sightings, poses, strict=True)]
    )


@pytest.fixture(scope="module")
def straight():
    """Eighty noisy frames of a straight lens, their poses, and what was seen."""
    settings, poses = small(), random_poses(80, WIDE)
    return settings, poses, detect_all(settings, render_all(settings, poses, REAL))


# Precision ----------------------------------------------------------------------------


@pytest.mark.parametrize("lens", [STRAIGHT, BENT], ids=["straight", "bent"])
def test_without_noise_both_geometries_agree(lens):
    settings, poses = small(lens), random_poses(40, WIDE, seed=2)
    errors = errors_of(detect_all(settings, render_all(settings, poses)), poses)
    assert rms(errors) < 0.5e-6


def test_noise_floor(straight):
    settings, poses, sightings = straight
    view = View(settings)
    pixels = [
        np.subtract(view.project(s.positions[0]), view.project(tuple(p.position)))
        for s, p in zip(sightings, poses, strict=True)
    ]
    assert rms(pixels) < 0.02
    assert rms(errors_of(sightings, poses)) < 1.2e-6


def test_sphere_beats_a_homography(straight):
    _, poses, sightings = straight
    view = View(straight[0])
    seen = np.array([view.project(s.positions[0]) for s in sightings])
    true = np.array([p.position[:2] for p in poses])
    # The best plane homography that calibration could find from these very frames.
    rows = []
    for (u, v), (x, y) in zip((seen - 255.5) / 256, true / H, strict=True):
        rows += [
            [u, v, 1, 0, 0, 0, -x * u, -x * v, -x],
            [0, 0, 0, u, v, 1, -y * u, -y * v, -y],
        ]
    best = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    mapped = np.column_stack([(seen - 255.5) / 256, np.ones(len(seen))]) @ best.T
    plane = mapped[:, :2] / mapped[:, 2:] * H - true
    sphere = np.array([s.positions[0][:2] for s in sightings]) - true
    assert rms(plane) > 30e-6
    assert rms(sphere) < 1e-6


@pytest.mark.parametrize("frequency", [0.1, 0.5])
def test_moving_marker_is_where_it_was_in_the_middle_of_the_exposure(frequency):
    settings = small()
    renderer = MarkerRenderer(settings, REAL, 5)
    tilt = math.radians(20.0)
    detector, errors = MarkerDetector(settings), []
    for k in range(60):
        middle = 2 * math.pi * frequency * k / 60
        swept = 2 * math.pi * frequency * settings.exposure
        parts = [pose(tilt, middle + swept * share) for share in (-0.375, -0.125, 0.125, 0.375)]
        seen = detector.detect(renderer.render(parts), k, k / 60)
        errors.append(np.subtract(seen.positions[0], pose(tilt, middle).position))
    assert rms(errors) < 1.5e-6
    assert detector.searches == 1


@pytest.mark.parametrize("slope", [0.0, 0.1])
def test_uneven_light_does_not_draw_the_centroid(slope):
    settings, item = small(), pose(0.2, 1.0)
    image = render_all(settings, [item])[0].astype(float)
    # What is behind an opaque disc gets lighter to the right, by 25 counts over its width.
    share = (image - 35.0) / 165.0
    image += (1.0 - share) * slope * np.arange(512)
    found = MarkerDetector(settings).detect(np.rint(image).astype(np.uint8), 0, 0.0)
    assert math.dist(found.positions[0], item.position) < 1e-6


def test_dark_disc_on_light_ground():
    settings, poses = small(polarity="dark"), random_poses(20, WIDE)
    errors = errors_of(detect_all(settings, render_all(settings, poses, REAL)), poses)
    assert rms(errors) < 3e-6


def test_wide_tilts():
    settings = MarkerCameraSettings(intrinsics=IntrinsicsSettings(k1=-0.1, k2=0.05))
    poses = [pose(math.radians(60.0), azimuth) for azimuth in np.linspace(0, 6, 12)]
    errors = errors_of(detect_all(settings, render_all(settings, poses, REAL)), poses)
    assert rms(errors) < 3e-6


# Tracking -----------------------------------------------------------------------------


def run_circle(settings, speed, frames=40, tilt=0.3):
    """Detect a marker that circles at a speed (rad per frame); how many whole frames it took."""
    renderer, detector = MarkerRenderer(settings, REAL, 2), MarkerDetector(settings)
    for k in range(frames):
        item = pose(tilt, speed * k)
        seen = detector.detect(renderer.render([item]), k, k / 60)
        assert seen.sight is Sight.SEEN
        assert math.dist(seen.positions[0], item.position) < 5e-6
    return detector.searches


def test_region_follows_the_joint_at_full_speed():
    assert run_circle(small(), 2 * math.pi * 0.5 / 60) == 1  # 0.5 Hz at 60 frames per second


def test_region_follows_ten_times_the_joints_speed_after_one_more_search():
    assert run_circle(small(), 2 * math.pi * 5 / 60) <= 2


def test_marker_that_jumped_is_found_again():
    settings = small()
    poses = [pose(0.3, 0.0), pose(0.3, math.pi), pose(0.3, 0.0)]
    detector = MarkerDetector(settings)
    for k, image in enumerate(render_all(settings, poses, REAL)):
        assert detector.detect(image, k, 0.0).sight is Sight.SEEN
    assert detector.searches == 3


def test_marker_is_found_after_dropped_frames():
    settings = small()
    detector = MarkerDetector(settings)
    speed = 2 * math.pi / 60
    frames = [0, 1, 2, 3, 8, 9]  # four are missing
    poses = [pose(0.3, speed * k) for k in frames]
    for k, image in zip(frames, render_all(settings, poses, REAL), strict=True):
        assert detector.detect(image, k, k / 60).sight is Sight.SEEN
    assert detector.searches == 1


def test_marker_at_the_border_of_the_region_is_not_measured_by_its_visible_part():
    settings = small()
    view, radius = View(settings), 31
    first, second = pose(0.0), pose(0.0)
    # The second is displaced by just so much that the first region cuts it.
    shift = (settings.roi / 2 - radius) / 3333 * 0.35
    second = pose(math.asin(shift / H))
    images = render_all(settings, [first, second], REAL)
    detector = MarkerDetector(settings)
    detector.detect(images[0], 0, 0.0)
    seen = detector.detect(images[1], 1, 0.0)
    assert math.dist(view.project(seen.positions[0]), view.project(tuple(second.position))) < 0.1


# What cannot be seen ------------------------------------------------------------------


def look(settings, image):
    return MarkerDetector(settings).detect(image, 0, 0.0)


def test_covered_lens_is_told_from_a_lost_marker():
    settings = small()
    renderer = MarkerRenderer(settings, REAL, 1)
    dark, empty = look(settings, renderer.render_darkness()), look(settings, renderer.render([]))
    assert dark.sight is Sight.COVERED
    assert dark.amount < settings.dark_level
    assert "lens is covered" in explain(dark, settings).what
    assert empty.sight is Sight.LOST
    assert empty.amount < settings.min_contrast
    assert "out of sight" in explain(empty, settings).what


def test_marker_is_lost_while_it_is_tracked_and_found_again():
    settings = small()
    renderer = MarkerRenderer(settings, REAL, 1)
    detector = MarkerDetector(settings)
    images = [
        renderer.render([pose(0.1)]),
        renderer.render_darkness(),
        renderer.render([]),
        renderer.render([pose(0.2)]),
    ]
    sights = [detector.detect(image, k, 0.0).sight for k, image in enumerate(images)]
    assert sights == [Sight.SEEN, Sight.COVERED, Sight.LOST, Sight.SEEN]


def test_other_disc_is_named_with_its_diameter():
    settings = small()
    image = MarkerRenderer(settings, REAL, 1).render([pose(0.1)], diameter=4e-3)
    seen = look(settings, image)
    assert seen.sight is Sight.SWAPPED
    assert seen.amount == pytest.approx(4e-3, rel=0.05)
    assert "another disc" in explain(seen, settings).what


def test_half_hidden_disc_is_not_measured():
    settings = small()
    image = render_all(settings, [pose(0.0)], REAL)[0]
    image[:, 256:] = 35
    assert look(settings, image).sight is Sight.SWAPPED


def test_disc_beside_the_sphere_is_named():
    settings = MarkerCameraSettings()
    beside = MarkerPose((0.05, 0.03, 0.05), np.eye(3))
    seen = look(settings, MarkerRenderer(settings, REAL, 1).render([beside]))
    assert seen.sight is Sight.OUTSIDE
    assert "sphere" in explain(seen, settings).what


def test_light_patch_that_is_not_the_marker_does_not_hide_it():
    settings = small()
    image = render_all(settings, [pose(0.2)], REAL)[0]
    image[20:150, 20:150] = 200  # larger than the disc, as bright
    assert look(settings, image).sight is Sight.SEEN


def test_frozen_image_is_named_once_it_has_come_often_enough():
    settings = small()
    image = render_all(settings, [pose(0.2)], REAL)[0]
    detector = MarkerDetector(settings)
    sights = [detector.detect(image, k, k / 60).sight for k in range(7)]
    assert sights == [Sight.SEEN] * 4 + [Sight.FROZEN] * 3
    assert detector.detect(image + 1, 7, 7 / 60).sight is Sight.SEEN


def test_image_of_another_size_is_refused():
    with pytest.raises(ValueError, match="640 x 480 pixels; the lens was calibrated for 512 x 512"):
        look(small(), np.zeros((480, 640), np.uint8))


@pytest.mark.parametrize("level", [0, 7, 128, 255])
def test_uniform_image_shows_nothing(level):
    seen = look(small(), np.full((512, 512), level, np.uint8))
    assert seen.sight is (Sight.COVERED if level < 8 else Sight.LOST)


@pytest.mark.parametrize("kind", ["blob", "aruco"])
def test_noise_alone_shows_nothing(kind):
    generator = np.random.default_rng(0)
    settings = small(kind=kind)
    for k in range(3):
        image = generator.integers(0, 256, (512, 512), np.uint8)
        seen = MarkerDetector(settings).detect(image, k, 0.0)
        assert seen.sight is not Sight.SEEN
        assert seen.positions == ()


@given(
    seed=st.integers(0, 2**32 - 1),
    patches=st.integers(0, 6),
    noise=st.sampled_from([0.0, 1.0, 30.0]),
    kind=st.sampled_from(["blob", "aruco"]),
)
@hypothesis_settings(max_examples=60, deadline=None)
def test_whatever_a_frame_shows_there_is_an_answer(seed, patches, noise, kind):
    generator = np.random.default_rng(seed)
    image = np.full((512, 512), generator.uniform(0, 255))
    for _ in range(patches):
        x, y = generator.integers(0, 512, 2)
        w, h = generator.integers(1, 90, 2)
        image[y : y + h, x : x + w] = generator.uniform(0, 255)
    image = np.clip(image + noise * generator.standard_normal(image.shape), 0, 255)
    settings = small(kind=kind)
    seen = MarkerDetector(settings).detect(image.astype(np.uint8), 0, 0.0)
    if seen.sight is Sight.SEEN:  # a square patch of the right size may pass for a disc
        assert math.hypot(*seen.positions[0]) == pytest.approx(H)
    else:
        assert explain(seen, settings).what


@pytest.mark.parametrize("tilt", [65.0, 75.0, 85.0])
def test_disc_seen_almost_edge_on_is_located_or_refused(tilt):
    settings = MarkerCameraSettings()
    item = pose(math.radians(tilt), 0.4)
    seen = look(settings, render_all(settings, [item], REAL)[0])
    if tilt < 70.0:
        assert seen.sight is Sight.SEEN
    if seen.sight is Sight.SEEN:
        assert math.dist(seen.positions[0], item.position) < 60e-6


# ArUco --------------------------------------------------------------------------------


@pytest.mark.parametrize("dictionary", ["4x4_50", "5x5_100", "6x6_250"])
def test_square_marker_shows_position_and_twist(dictionary):
    settings = small(BENT, kind="aruco", dictionary=dictionary, ids=(7,))
    poses = random_poses(25, math.radians(20.0), seed=4, twist=0.5)
    sightings = detect_all(settings, render_all(settings, poses, REAL))
    assert {item.ids for item in sightings} == {(7,)}
    assert rms(errors_of(sightings, poses)) < 15e-6
    errors = [
        seen.twists[0] - twist_of(item.rotation)
        for seen, item in zip(sightings, poses, strict=True)
    ]
    assert rms(np.array(errors)[:, None]) < 2e-3


def test_square_marker_at_forty_degrees():
    settings = MarkerCameraSettings(marker=MarkerSettings(kind="aruco"))
    poses = [pose(math.radians(40.0), azimuth, 0.1) for azimuth in np.linspace(0, 6, 10)]
    sightings = detect_all(settings, render_all(settings, poses, REAL))
    assert rms(errors_of(sightings, poses)) < 25e-6
    assert [item.twists[0] for item in sightings] == pytest.approx([0.1] * 10, abs=5e-3)


def test_other_number_is_named():
    settings = small(kind="aruco", ids=(3,))
    image = MarkerRenderer(settings, REAL, 1).render([pose(0.1)], number=12)
    seen = look(settings, image)
    assert (seen.sight, seen.amount) == (Sight.SWAPPED, 12.0)
    assert explain(seen, settings)[1:] == ("number 12", "number 3")


def test_mirror_writing_is_named():
    settings = small(kind="aruco", ids=(3,))
    image = render_all(settings, [pose(0.1)], REAL)[0][:, ::-1].copy()
    seen = look(settings, image)
    assert (seen.sight, seen.amount) == (Sight.MIRRORED, 3.0)
    assert "mirrored" in explain(seen, settings).what


# Parts --------------------------------------------------------------------------------


def test_otsu_splits_two_levels():
    image = np.full((50, 50), 20, np.uint8)
    image[10:20, 10:30] = 180
    split = split_levels(compute_histogram(image))
    assert 20 <= split.threshold < 180
    assert split.contrast == pytest.approx(160.0)


def test_otsu_agrees_with_opencv_on_a_noisy_region():
    import cv2

    image = render_all(small(), [pose(0.1)], REAL)[0][150:350, 200:400]
    image = np.ascontiguousarray(image)
    reference = cv2.threshold(image, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0]
    split = split_levels(compute_histogram(image))
    assert ((image > split.threshold) == (image > reference)).mean() > 0.999


def test_largest_blob_wins_and_a_cut_one_is_marked():
    image = np.zeros((60, 60), np.uint8)
    image[5:8, 5:8] = 200
    image[20:40, 30:50] = 200
    blob = find_largest_blob(image, 100)
    assert (blob.x, blob.y, blob.area, blob.cut) == pytest.approx((39.5, 29.5, 400, False))
    assert find_largest_blob(image[:, :45], 100).cut
    assert find_largest_blob(image, 220) is None


@pytest.mark.parametrize(
    "sighting",
    [
        Sighting(3, 1.25, Sight.SEEN, (0,), ((1e-3, -2e-3, 0.05),), (0.25,), 0.5),
        Sighting(2**40, -1.0, Sight.LOST, amount=12.5),
        Sighting(0, 0.0, Sight.SEEN, (1, 2), ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)), (0.1, 0.2), 0.0),
    ],
)
def test_sightings_survive_the_way_between_processes(sighting):
    assert decode_sighting(encode_sighting(sighting)) == sighting


def test_a_blob_is_found_in_a_copy_of_the_process():
    """A campaign copies a run, and a pool of OpenCV's threads would not come along."""
    disc = np.zeros((400, 600), np.uint8)
    disc[100:160, 200:260] = 255
    context = multiprocessing.get_context("fork")
    for _ in range(5):
        assert find_largest_blob(disc, 128) is not None
        copy = context.Process(target=find_largest_blob, args=(disc, 128), daemon=True)
        copy.start()
        copy.join(20.0)
        assert copy.exitcode == 0
    assert cv2.getNumThreads() == 1


def test_mutilated_sightings_are_refused():
    data = encode_sighting(Sighting(3, 1.25, Sight.SEEN, (0,), ((1.0, 2.0, 3.0),), (0.25,), 0.5))
    with pytest.raises(ValueError, match="does not have"):
        decode_sighting(data[:-1])
    with pytest.raises(ValueError, match="at least"):
        decode_sighting(data[:5])
    with pytest.raises(ValueError, match="99 is not a valid Sight"):
        decode_sighting(data[:16] + bytes([99]) + data[17:])
