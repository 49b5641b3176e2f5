"""What a camera shows to whoever looks on: nothing unless it is asked, and then what it saw."""

import os

import cv2
import numpy as np
import pytest
from camera_recording import FILE, recorded, render_frames

from drivers.marker_camera.detector import MarkerDetector
from drivers.marker_camera.device import MarkerCameraDriver
from drivers.marker_camera.shown import ShownFrames, offer_pictures
from rig.hal import MonotonicClock, pictures
from rig.hal.pictures import LARGEST, PictureFile, Snapshot

SEEN = Snapshot(7, 1280, 1024, "seen", ((640.25, 511.5),), b"\xff\xd8\xff" + bytes(range(256)))
CLOCK = MonotonicClock()


@pytest.fixture
def both(tmp_path):
    """The file as the camera has it, and as who looks on has it."""
    path = tmp_path / "camera.picture"
    camera, eye = PictureFile(path, create=True), PictureFile(path)
    yield camera, eye
    camera.close()
    eye.close()


def test_a_picture_is_wanted_for_two_seconds_after_it_was_asked_for(both, monkeypatch):
    camera, eye = both
    assert not camera.is_wanted()
    now = 1000.0
    monkeypatch.setattr(pictures, "monotonic", lambda: now)
    eye.ask()
    assert camera.is_wanted()
    now = 1001.9
    assert camera.is_wanted()
    now = 1002.1
    assert not camera.is_wanted()
    now = 900.0  # the machine has been started anew since
    assert not camera.is_wanted()


def test_what_is_put_there_is_found_once(both):
    camera, eye = both
    assert eye.newest() is None
    camera.put(SEEN)
    assert eye.newest() == SEEN
    assert eye.newest() is None
    for number in range(3):
        camera.put(SEEN._replace(frame=number, marks=()))
    assert eye.newest() == SEEN._replace(frame=2, marks=())


def test_a_picture_that_is_just_being_written_is_no_picture(both, tmp_path):
    camera, eye = both
    camera.put(SEEN)
    content = (tmp_path / "camera.picture").read_bytes()
    for at in range(24, len(content)):  # each byte in turn is that of another picture
        if not content[at : at + 1].strip(b"\0") and at < 64:
            continue
        damaged = bytearray(content)
        damaged[at] ^= 0xFF
        (tmp_path / "camera.picture").write_bytes(damaged)
        assert eye.newest() is None or at < 32  # the number alone may be any
    (tmp_path / "camera.picture").write_bytes(content[:-1])
    assert PictureFile(tmp_path / "camera.picture").newest() is None


def test_too_large_a_picture_and_too_many_marks_are_cut(both):
    camera, eye = both
    camera.put(SEEN._replace(jpeg=b"x" * (LARGEST + 1)))
    assert eye.newest() is None
    camera.put(SEEN._replace(marks=((1.0, 2.0),) * 99, verdict="é" * 40, jpeg=b"x" * LARGEST))
    found = eye.newest()
    assert len(found.marks) == 16
    assert len(found.jpeg) == LARGEST
    camera.put(SEEN._replace(marks=((float("nan"), 1.0),)))
    assert eye.newest() is None


def test_nothing_but_such_a_file_is_opened(tmp_path):
    other = tmp_path / "other"
    other.write_text("a diary")
    link, pipe = tmp_path / "link.picture", tmp_path / "pipe.picture"
    link.symlink_to(other)
    os.mkfifo(pipe)
    for path in (other, pipe):
        with pytest.raises(ValueError, match="holds no picture"):
            PictureFile(path)
    for path in (link, tmp_path / "none"):
        with pytest.raises(OSError):
            PictureFile(path)
    assert offer_pictures(other) is None  # nor is anything written over
    assert other.read_text() == "a diary"
    assert offer_pictures(tmp_path / "nowhere" / "camera.picture") is None


def test_frames_are_shown_as_they_were_searched_while_somebody_looks_on(tmp_path, monkeypatch):
    path = offer_pictures(tmp_path / "camera.picture")
    shown, eye = ShownFrames(path), PictureFile(path)
    detector = MarkerDetector(recorded(FILE))
    (image,) = render_frames(1)
    sighting = detector.detect(image, 5, 0.1)
    shown.offer(image, sighting, detector.places)
    assert path.stat().st_size < 100  # nobody asked, and nothing was written
    eye.ask()
    shown.offer(image, sighting, detector.places)
    picture = eye.newest()
    assert (picture.frame, picture.verdict) == (5, "seen")
    # The mark is where the picture itself is brightest, found here without the detector.
    got = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_UNCHANGED)
    rows, columns = np.nonzero(got > 150)
    scale = picture.width / got.shape[1]
    assert picture.marks[0][0] == pytest.approx((columns.mean() + 0.5) * scale - 0.5, abs=1.0)
    assert picture.marks[0][1] == pytest.approx((rows.mean() + 0.5) * scale - 0.5, abs=1.0)
    shown.offer(image, sighting, detector.places)
    assert eye.newest() is None  # ten in a second are enough for an eye


def test_the_process_of_a_camera_shows_what_it_grabs(tmp_path):
    camera = MarkerCameraDriver("camera", recorded(FILE), CLOCK)
    camera.show_in(tmp_path)
    eye = PictureFile(tmp_path / "camera.picture")
    camera.connect()
    try:
        picture, until = None, CLOCK.now() + 60.0
        while picture is None:
            assert CLOCK.now() < until
            eye.ask()
            camera.markers()
            CLOCK.sleep_until(CLOCK.now() + 1e-2)
            picture = eye.newest()
    finally:
        camera.close()
        eye.close()
    assert picture.verdict == "seen"
    assert picture.jpeg.startswith(b"\xff\xd8\xff")
    assert not (tmp_path / "camera.picture").exists()  # the run's folder keeps no trace of it
