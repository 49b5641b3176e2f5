"""Sources of frames: recordings made here, and a UVC camera behind a stand-in for OpenCV."""

import math
import os
import re
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from camera_recording import (
    FILE,
    FRAMES,
    recorded,
    render_frames,
    true_pose,
    write_images,
    write_video,
)
from camera_scenes import rms

from drivers.marker_camera.detector import MarkerDetector
from drivers.marker_camera.image_files import folder_images, video_frames
from drivers.marker_camera.image_source import RecordingEnded, SourceFailure
from drivers.marker_camera.settings import MarkerCameraSettings, SourceSettings
from drivers.marker_camera.sighting import Sight
from drivers.marker_camera.sources import open_source
from drivers.marker_camera.uvc import UvcSource, read_usb_serial


class StandingClock:
    """A clock that only moves when somebody sleeps."""

    def __init__(self, now=100.0):
        self.t = now
        self.slept = []

    def now(self):
        return self.t

    def sleep_until(self, t):
        self.slept.append(t)
        self.t = max(self.t, t)


def play(settings, clock=None):
    source = open_source(settings, clock or StandingClock())
    source.open()
    frames = []
    try:
        while True:
            frames.append(source.read())
    except RecordingEnded:
        return frames
    finally:
        source.close()


@pytest.fixture(scope="module")
def images():
    return render_frames()


# The recording in the repository ------------------------------------------------------


def test_recorded_circle_is_detected_in_every_frame():
    settings = recorded(FILE)
    detector = MarkerDetector(settings)
    frames = play(settings)
    assert [frame.number for frame in frames] == list(range(FRAMES))
    sightings = [detector.detect(*frame) for frame in frames]
    assert {item.sight for item in sightings} == {Sight.SEEN}
    errors = [
        np.subtract(item.positions[0], true_pose(k).position) for k, item in enumerate(sightings)
    ]
    assert rms(np.array(errors)) < 8e-6  # JPEG blocks cost three quarters of it
    assert detector.searches == 1
    radii = [math.hypot(*item.positions[0][:2]) for item in sightings]
    assert np.mean(radii) == pytest.approx(18e-3, abs=2e-6)


def test_recorded_circle_is_what_its_script_makes(images):
    for frame, image in zip(play(recorded(FILE)), images, strict=True):
        assert np.abs(frame.image.astype(int) - image).max() < 40  # JPEG rings at the edge
        assert np.abs(frame.image.astype(int) - image).mean() < 1.5


# Recordings ---------------------------------------------------------------------------


def test_lossless_video_gives_the_very_images(tmp_path, images):
    path = write_video(tmp_path / "circle.avi", images[:6], "FFV1")
    frames = play(recorded(path))
    assert len(frames) == 6
    assert all((f.image == image).all() for f, image in zip(frames, images, strict=False))


def test_folder_is_played_in_the_order_of_its_names(tmp_path, images):
    folder = write_images(tmp_path / "frames", images[:4])
    (folder / "frame-0001.png").rename(folder / "frame-9999.png")
    (folder / "notes.txt").write_text("not an image")
    frames = play(recorded(folder, "images"))
    played = [0, 2, 3, 1]
    assert all((f.image == images[k]).all() for f, k in zip(frames, played, strict=True))


def test_colour_images_become_grey(tmp_path, images):
    folder = tmp_path / "frames"
    folder.mkdir()
    cv2.imwrite(str(folder / "a.png"), cv2.cvtColor(images[0], cv2.COLOR_GRAY2BGR))
    (frame,) = play(recorded(folder, "images"))
    assert np.abs(frame.image.astype(int) - images[0]).max() <= 1


def test_paced_recording_comes_at_its_rate_with_its_latency():
    settings, clock = recorded(FILE), StandingClock(50.0)
    frames = play(settings, clock)
    times = [50.0 + k / 60 for k in range(FRAMES)]
    assert [frame.t for frame in frames] == pytest.approx(times)
    assert clock.slept == pytest.approx([t + settings.latency for t in times])


def test_unpaced_recording_never_sleeps():
    clock = StandingClock()
    assert len(play(recorded(FILE, paced=False), clock)) == FRAMES
    assert clock.slept == []


def test_repeated_recording_goes_on_counting():
    source = open_source(recorded(FILE, repeat=True), StandingClock())
    source.open()
    frames = [source.read() for _ in range(FRAMES + 2)]
    source.close()
    assert frames[-1].number == FRAMES + 1
    assert (frames[-1].image == frames[1].image).all()


def test_end_of_a_recording_is_named_with_its_length():
    source = open_source(recorded(FILE, paced=False), StandingClock())
    source.open()
    for _ in range(FRAMES):
        source.read()
    with pytest.raises(RecordingEnded) as caught:
        source.read()
    assert (caught.value.value, caught.value.object) == ("40 frames", str(FILE))


@pytest.mark.parametrize("kind", ["video", "images"])
def test_missing_recording_is_named(kind, tmp_path):
    with pytest.raises(SourceFailure, match="no such recording") as caught:
        open_source(recorded(tmp_path / "gone", kind), StandingClock()).open()
    assert caught.value.object == str(tmp_path / "gone")


def test_empty_folder_is_refused(tmp_path):
    with pytest.raises(SourceFailure, match="no frames"):
        open_source(recorded(tmp_path, "images"), StandingClock()).open()


def test_file_is_no_folder():
    with pytest.raises(SourceFailure, match="not a folder"):
        open_source(recorded(FILE, "images"), StandingClock()).open()


def test_file_that_is_no_image_is_named(tmp_path):
    (tmp_path / "a.png").write_text("no image")
    with pytest.raises(SourceFailure, match="not an image") as caught:
        open_source(recorded(tmp_path, "images"), StandingClock()).open()
    assert caught.value.object.endswith("a.png")


def test_file_that_is_no_video_is_named(tmp_path):
    (tmp_path / "a.avi").write_text("no video")
    with pytest.raises(SourceFailure, match="not a video"):
        next(video_frames(tmp_path / "a.avi"))


def huge_png():
    """Return a PNG of 900 million black pixels in less than a megabyte."""
    parts = [b"\x89PNG\r\n\x1a\n"]
    packed = zlib.compressobj(9)
    rows = [packed.compress(bytes(30_001)) for _ in range(30_000)]
    header = struct.pack(">IIBBBBB", 30_000, 30_000, 8, 0, 0, 0, 0)
    for kind, data in ((b"IHDR", header), (b"IDAT", b"".join(rows) + packed.flush())):
        parts += [struct.pack(">I", len(data)), kind, data]
        parts.append(struct.pack(">I", zlib.crc32(kind + data)))
    return b"".join(parts)


def test_an_image_that_would_fill_the_memory_is_none(tmp_path):
    (tmp_path / "a.png").write_bytes(huge_png())
    Path("/proc/self/clear_refs").write_text("5")
    before = Path("/proc/self/status").read_text()
    with pytest.raises(SourceFailure, match="not an image"):
        next(folder_images(tmp_path))
    most = [int(re.search(r"VmHWM:\s+(\d+)", text)[1])
            for text in (before, Path("/proc/self/status").read_text())]  # fmt: skip
    assert most[1] - most[0] < 200_000  # kB


@pytest.mark.parametrize("play", [video_frames, folder_images])
def test_a_pipe_is_no_recording_and_not_waited_for(play, tmp_path):
    pipe = tmp_path / ("a.avi" if play is video_frames else "a.png")
    os.mkfifo(pipe)
    with pytest.raises(SourceFailure, match="not a regular file"):
        next(play(pipe if play is video_frames else tmp_path))


def test_recording_of_another_size_is_refused():
    settings = replace(recorded(FILE), width=1280, height=1024)
    with pytest.raises(SourceFailure, match="not of the size") as caught:
        open_source(settings, StandingClock()).open()
    assert (caught.value.value, caught.value.bound) == ("640 x 512 pixels", "1280 x 1024 pixels")


def test_serial_number_is_noted_beside_a_recording(tmp_path, images):
    path = write_video(tmp_path / "circle.avi", images[:2])
    (tmp_path / "circle.serial").write_text("4711\n")
    folder = write_images(tmp_path / "frames", images[:2])
    (folder / "camera.serial").write_text("4712\n")
    for settings, serial in (
        (recorded(path), "4711"),
        (recorded(folder, "images"), "4712"),
        (recorded(FILE), None),
    ):
        source = open_source(settings, StandingClock())
        source.open()
        source.close()
        assert source.serial == serial


# UVC ----------------------------------------------------------------------------------

UVC = MarkerCameraSettings(source=SourceSettings(path="3"), width=640, height=512)


class StandInCapture:
    """A camera as `cv2.VideoCapture` shows it: frames on a grid of time, queued by the kernel."""

    def __init__(self, clock, *, opened=True, stamped=True, refuses=(), channels=1):
        self.clock = clock
        self.opened = opened
        self.stamped = stamped
        self.refuses = refuses
        self.channels = channels
        self.controls = {}
        self.grabbed = 0
        self.unplugged = False
        self.released = 0
        self.start = clock.now()

    def isOpened(self):
        return self.opened

    def set(self, control, value):
        if control not in self.refuses:
            self.controls[control] = value
        return True

    def get(self, control):
        if control == cv2.CAP_PROP_POS_MSEC:
            return 1e3 * self._arrival() if self.stamped else 0.0
        return self.controls.get(control, -1.0)

    def grab(self):
        if self.unplugged:
            return False
        self.grabbed += 1
        self.clock.t = max(self.clock.t, self._arrival() + 0.5e-3)
        return True

    def retrieve(self):
        shape = (512, 640) if self.channels == 1 else (512, 640, self.channels)
        return True, np.full(shape, self.grabbed, np.uint8)

    def release(self):
        self.released += 1

    def _arrival(self):
        return self.start + self.grabbed / 60


def opened(**options):
    clock = StandingClock()
    capture = StandInCapture(clock, **options)
    paths = []
    source = UvcSource(UVC, clock, lambda path: paths.append(path) or capture)
    source.open()
    assert paths == ["/dev/video3"]
    return clock, capture, source


def test_uvc_camera_is_set_to_a_fixed_exposure():
    _, capture, _ = opened()
    controls = capture.controls
    assert controls[cv2.CAP_PROP_AUTO_EXPOSURE] == 1.0
    assert controls[cv2.CAP_PROP_EXPOSURE] == pytest.approx(50.0)  # 5 ms in 100 µs
    assert (controls[cv2.CAP_PROP_FRAME_WIDTH], controls[cv2.CAP_PROP_FRAME_HEIGHT]) == (640, 512)
    assert controls[cv2.CAP_PROP_FPS] == 60.0
    assert controls[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"GREY")


@pytest.mark.parametrize(
    ("control", "what"),
    [
        (cv2.CAP_PROP_FRAME_WIDTH, "image width"),
        (cv2.CAP_PROP_FPS, "frame rate"),
        (cv2.CAP_PROP_AUTO_EXPOSURE, "exposure mode"),
        (cv2.CAP_PROP_EXPOSURE, "exposure time"),
    ],
)
def test_setting_that_a_uvc_camera_does_not_take_is_named(control, what):
    with pytest.raises(SourceFailure, match=f"did not take the {what}") as caught:
        opened(refuses=(control,))
    assert caught.value.object == "/dev/video3"
    assert caught.value.value.startswith("-1")


def test_absent_uvc_camera_is_named():
    with pytest.raises(SourceFailure, match="no camera at its path") as caught:
        opened(opened=False)
    assert caught.value.object == "/dev/video3"


def test_there_is_no_camera_on_this_path():
    settings = replace(UVC, source=SourceSettings(path="/dev/video-of-nobody"))
    source = UvcSource(settings, StandingClock())
    with pytest.raises(SourceFailure, match="at its path: it is not there; plug it in"):
        source.open()
    source.close()


@pytest.mark.parametrize("stamped", [True, False])
def test_uvc_frame_bears_the_middle_of_its_exposure(stamped):
    _, _, source = opened(stamped=stamped)
    frame = source.read()
    arrival = 100.0 + 1 / 60 + (0.0 if stamped else 0.5e-3)
    assert frame.t == pytest.approx(arrival - UVC.latency, abs=1e-6)
    assert frame.number == 0
    assert frame.image.shape == (512, 640)


def test_uvc_frames_that_queued_up_are_dropped():
    clock, capture, source = opened()
    assert source.read().number == 0
    clock.t += 3.3 / 60  # the detector took long: three frames wait
    frame = source.read()
    assert capture.grabbed == 4
    assert frame.number == 3
    assert source.read().number == 4


@pytest.mark.parametrize("channels", [2, 3])
def test_uvc_frames_in_colour_become_grey(channels):
    _, _, source = opened(channels=channels)
    frame = source.read()
    assert frame.image.shape == (512, 640)
    assert (frame.image == 1).all()


def test_unplugged_uvc_camera_is_named():
    _, capture, source = opened()
    source.read()
    capture.unplugged = True
    with pytest.raises(SourceFailure, match="unplugged") as caught:
        source.read()
    assert caught.value.value == "1 frames"
    source.close()
    source.close()
    assert capture.released == 1


def test_usb_serial_number_is_found_where_the_kernel_lists_it(tmp_path):
    device = tmp_path / "usb" / "1-2"
    (device / "1-2:1.0").mkdir(parents=True)
    (device / "serial").write_text("00A1\n")
    entry = tmp_path / "class" / "video0"
    entry.mkdir(parents=True)
    (entry / "device").symlink_to(device / "1-2:1.0")
    assert read_usb_serial("/dev/video0", tmp_path / "class") == "00A1"
    assert read_usb_serial("/dev/video1", tmp_path / "class") is None
