"""A lens from views of a board: what is found, and which views are refused."""

import os
import shutil

import cv2
import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.assembly.simulated import board_renderer
from rig.calibration.catalogue import procedures
from rig.calibration.recording import CalibrationRefused
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError
from rig.mechanisms.joint.calibration.board_lens import Board, Views, fit_lens, read_views
from rig.mechanisms.joint.calibration.board_views import VIEWS, simulate_views

BOARD = Board()
SIZE = (1280, 1024)
TRUE = {"fx": 3290.0, "fy": 3310.0, "cx": 650.0, "cy": 500.0, "k1": -0.08, "k2": 0.1}


@pytest.fixture(scope="module")
def profile():
    return load_profile("joint", REGISTRY, (), find_configs())


def made(tilt=0.5, spread=1.0, count=12, noise=0.05):
    """Return the corners of a board in views of a lens, with noise."""
    rng = np.random.default_rng(4)
    matrix = np.array([[TRUE["fx"], 0, TRUE["cx"]], [0, TRUE["fy"], TRUE["cy"]], [0, 0, 1.0]])
    bend = np.array([TRUE["k1"], TRUE["k2"], 0, 0, 0])
    rows = []
    for k in range(count):
        turn = np.array([tilt * np.cos(2.4 * k), tilt * np.sin(2.4 * k), 0.1])
        corner = spread * 0.03 * np.array([(-1) ** k, (-1) ** (k // 2)])
        place = np.array([*(corner - [0.036, 0.024]), 0.42])
        shown = cv2.projectPoints(BOARD.corners, turn, place, matrix, bend)[0].reshape(-1, 2)
        rows.append(shown + noise * rng.standard_normal(shown.shape))
    return Views(BOARD, (), SIZE, tuple(f"{k}" for k in range(count)), np.array(rows), count)


def test_finds_the_lens_within_its_intervals(profile):
    guess = profile.devices["camera"].settings.intrinsics
    found = fit_lens(made(), guess)
    for name, true in TRUE.items():
        assert abs(found.values[name] - true) < 3.5 * found.stds[name], name
    assert np.sqrt(np.mean(found.residuals**2)) == pytest.approx(0.05, rel=0.1)


def test_intervals_hold_when_some_views_are_sharper_than_others(profile):
    guess = profile.devices["camera"].settings.intrinsics
    rng = np.random.default_rng(7)
    exact = made(noise=0.0)
    errors = []
    for _ in range(25):
        blur = rng.uniform(0.02, 0.15, (len(exact.corners), 1, 2))  # across and down, by view
        noisy = exact.corners + blur * rng.standard_normal(exact.corners.shape)
        found = fit_lens(exact._replace(corners=noisy), guess)
        errors.append([(found.values[name] - TRUE[name]) / found.stds[name] for name in TRUE])
    held = np.abs(errors) < 1.96
    # 150 errors: 90 % is 3 standard deviations below 95 %.
    assert 0.90 <= held.mean() <= 0.99
    assert np.std(errors, axis=0) == pytest.approx(np.ones(6), abs=0.35)


def test_a_board_that_always_faces_the_camera_is_refused(profile):
    guess = profile.devices["camera"].settings.intrinsics
    with pytest.raises(CalibrationRefused, match="faced the camera alike"):
        fit_lens(made(tilt=0.02), guess)


def test_a_board_that_stays_in_the_middle_is_refused(profile):
    guess = profile.devices["camera"].settings.intrinsics
    views = made(spread=0.0)
    small = views._replace(corners=0.4 * views.corners + 0.6 * views.corners.mean(axis=(0, 1)))
    with pytest.raises(CalibrationRefused, match="at least 50 % are needed"):
        fit_lens(small, guess)


def test_images_of_another_size_are_not_of_this_camera(profile):
    views = made()._replace(size=(640, 480))
    with pytest.raises(CalibrationRefused, match="640 x 480 pixels, camera has 1280 x 1024"):
        procedures(profile)["lens"].identify(profile, views, {})


def test_a_folder_without_a_board_is_refused(tmp_path):
    with pytest.raises(CalibrationRefused, match="holds no image"):
        read_views(tmp_path, BOARD)
    cv2.imwrite(str(tmp_path / "grey.png"), np.full((120, 160), 90, np.uint8))
    with pytest.raises(CalibrationRefused, match="0 of 1 images show a board of 10 x 7 squares"):
        read_views(tmp_path, BOARD)


def test_a_pipe_is_no_view_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.png")
    with pytest.raises(CalibrationRefused, match="holds no image"):
        read_views(tmp_path, BOARD)
    os.mkfifo(tmp_path / "a.avi")
    with pytest.raises(ConfigurationError, match="not a regular file"):
        read_views(tmp_path / "a.avi", BOARD)


@pytest.mark.parametrize(
    ("text", "what"),
    [("10x7", "is no board"), ("8x6x5mm", "one number odd"), ("10x7x-1mm", "have a side")],
)
def test_boards_that_cannot_be_used(text, what):
    assert Board.parse("9x6x10 mm") == Board(9, 6, 10e-3)
    with pytest.raises(CalibrationRefused, match=what):
        Board.parse(text)


def test_the_rendered_board_is_seen_where_it_is(profile):
    render = board_renderer(profile, "camera", *BOARD)
    held, sheet = np.array([0.3, -0.2, 0.1]), np.array([0.01, -0.005, 0.42])
    image = render(held, sheet)
    there, corners = cv2.findChessboardCornersSB(image, (9, 6), flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    assert there
    lens = profile.devices["camera"].settings.intrinsics
    matrix = np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1.0]])
    _, turn, place = cv2.solvePnP(BOARD.corners, corners, matrix, np.zeros(5))
    middle = cv2.Rodrigues(turn)[0] @ BOARD.corners.mean(axis=0) + place.ravel()
    # Seven rows stand half a square above the middle of a sheet of twelve.
    above = cv2.Rodrigues(held)[0] @ (0.0, -0.5 * BOARD.square, 0.0)
    assert middle == pytest.approx(sheet + above, abs=2e-4)


@pytest.mark.slow
def test_simulated_views_say_what_the_lens_is(profile, tmp_path):
    folder = simulate_views(profile, "camera", BOARD, tmp_path)
    views = read_views(folder / VIEWS, BOARD)
    (finding,) = procedures(profile)["lens"].identify(profile, views, {})
    true = profile.devices["camera"].settings.intrinsics
    for e in finding.estimates:
        assert abs(e.value - getattr(true, e.name)) < 4.0 * e.std, e.name
    shutil.rmtree(folder)
