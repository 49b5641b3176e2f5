"""The driver with its process, end to end, on recordings made here."""

import os
import signal
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

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

from drivers.marker_camera.device import MarkerCameraDriver
from drivers.marker_camera.link import Failure, Ready
from drivers.marker_camera.process import ProcessLink
from drivers.marker_camera.sighting import Sight, Sighting
from drivers.marker_camera.worker import decode_event, encode_event
from rig.hal import ConnectionFailed, DeviceFault, MonotonicClock

CLOCK = MonotonicClock()
PATIENCE = 60.0  # for a loaded machine; nothing here waits for a time to pass


def wait_for(done):
    """Poll until something is true."""
    until = CLOCK.now() + PATIENCE
    while not done():
        assert CLOCK.now() < until, "it never happened"
        CLOCK.sleep_until(CLOCK.now() + 1e-3)


@pytest.fixture
def driver():
    """Make drivers, and close them at the end."""
    made = []

    def make(settings, **options):
        made.append(MarkerCameraDriver("camera", settings, CLOCK, **options))
        return made[-1]

    yield make
    for item in made:
        item.close()


def collect(link):
    """Every event of a link up to its failure."""
    events = []

    def done():
        events.extend(link.poll(CLOCK.now()))
        return bool(events) and isinstance(events[-1], Failure)

    wait_for(done)
    return events


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_images(tmp_path_factory.mktemp("recording") / "frames", render_frames(12))


@pytest.mark.parametrize("kind", ["video", "images"])
def test_every_frame_of_a_recording_comes_out_of_the_process(kind, folder):
    path, count = (FILE, FRAMES) if kind == "video" else (folder, 12)
    link = ProcessLink(recorded(path, kind, paced=False))
    link.open(CLOCK.now())
    try:
        ready, *sightings, end = collect(link)
    finally:
        link.close()
    assert ready == Ready(None)
    assert end == Failure("the recording has ended", str(path), f"{count} frames")
    assert [item.frame for item in sightings] == list(range(count))
    assert {item.sight for item in sightings} == {Sight.SEEN}
    errors = [np.subtract(s.positions[0], true_pose(s.frame).position) for s in sightings]
    assert rms(np.array(errors)) < 8e-6
    steps = np.diff([item.t for item in sightings])
    assert steps == pytest.approx([1 / 60] * (count - 1), abs=1e-9)


def test_driver_gives_the_newest_markers_and_their_time(driver):
    camera = driver(recorded(FILE, repeat=True))
    camera.connect()
    camera.arm()
    seen = camera.markers()
    assert seen.value.ids == (0,)
    assert 0.0 < CLOCK.now() - seen.t < PATIENCE
    assert camera.twists().t == seen.t
    wait_for(lambda: camera.markers().t > seen.t)


def test_end_of_a_recording_is_a_fault_of_the_device(driver):
    camera = driver(recorded(FILE, paced=False))
    camera.connect()
    camera.arm()

    def ended():
        camera.markers()
        try:
            camera.check(CLOCK.now())
        except DeviceFault as fault:
            assert str(fault) == (
                f"camera: the recording has ended [object {FILE}, value 40 frames]"
            )
            return True
        return False

    wait_for(ended)


def test_killed_process_is_a_fault_that_names_it(driver):
    link = ProcessLink(recorded(FILE, repeat=True))
    camera = driver(recorded(FILE, repeat=True), link=link)
    camera.connect()
    camera.arm()
    os.kill(link.process.pid, signal.SIGKILL)
    link.process.wait()

    def failed():
        camera.markers()
        try:
            camera.check(CLOCK.now())
        except DeviceFault as fault:
            assert "camera: its grabbing process ended [value signal SIGKILL]" in str(fault)
            return True
        return False

    wait_for(failed)


@pytest.mark.parametrize("kind", ["video", "images"])
def test_missing_recording_is_refused_by_name(driver, tmp_path, kind):
    camera = driver(recorded(tmp_path / "gone", kind))
    with pytest.raises(ConnectionFailed, match="camera: there is no such recording") as caught:
        camera.connect()
    assert str(tmp_path / "gone") in str(caught.value)


def test_absent_uvc_camera_is_refused_by_name(driver):
    camera = driver(recorded("/dev/video-of-nobody", "uvc"))
    with pytest.raises(
        ConnectionFailed, match=r"camera: there is no camera .*/dev/video-of-nobody"
    ):
        camera.connect()


@pytest.mark.parametrize(
    ("serial", "calibrated"),
    [(4711, None), (None, "4711")],
    ids=["named by the profile", "calibrated"],
)
def test_other_camera_is_refused(driver, serial, calibrated):
    settings = replace(recorded(FILE), calibrated_serial=calibrated)
    camera = driver(settings, serial=serial)
    with pytest.raises(ConnectionFailed, match="another camera") as caught:
        camera.connect()
    assert (caught.value.value, caught.value.bound) == ("none", "4711")


def test_serial_number_may_start_with_zeros(driver, tmp_path):
    path = write_video(tmp_path / "circle.avi", render_frames(2))
    (tmp_path / "circle.serial").write_text("0004711\n")
    camera = driver(replace(recorded(path), calibrated_serial="0004711"), serial=4711)
    camera.connect()


def test_driver_can_be_closed_in_any_state_and_opened_again(driver):
    camera = driver(recorded(FILE, repeat=True))
    camera.close()
    for _ in range(2):
        camera.connect()
        camera.arm()
        camera.make_safe()
        camera.close()
        camera.close()


def test_process_ends_with_the_program_that_started_it():
    program = textwrap.dedent(
        f"""
        import sys, os, signal
        sys.path[:0] = {[*sys.path]!r}
        from camera_recording import recorded, FILE
        from drivers.marker_camera.process import ProcessLink
        link = ProcessLink(recorded(FILE, repeat=True))
        link.open(0.0)
        while not link.poll(0.0):
            pass
        print(link.process.pid, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
        """
    )
    result = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert result.returncode == -signal.SIGKILL, result.stderr
    child = int(result.stdout)

    def gone():
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return True
        # Ended, and nobody has asked how.
        return Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[0] == "Z"

    wait_for(gone)


@pytest.mark.parametrize(
    "event",
    [
        Ready("00A1"),
        Ready(None),
        Failure("it was unplugged", "/dev/video0", "3 frames", None),
        Sighting(3, 1.25, Sight.LOST, amount=2.5),
    ],
)
def test_events_survive_the_way_between_processes(event):
    assert decode_event(encode_event(event)) == event


def test_packet_of_nobody_is_refused():
    with pytest.raises(ValueError, match="No event starts with"):
        decode_event(b"X")


def test_error_that_nobody_foresaw_is_told_before_the_process_ends(tmp_path):
    images = render_frames(2)
    folder = write_images(tmp_path / "frames", [images[0], images[1][:200]])
    link = ProcessLink(recorded(folder, "images", paced=False))
    link.open(CLOCK.now())
    try:
        *_, seen, end = collect(link)
    finally:
        link.close()
    assert isinstance(seen, Sighting)
    assert end.what.startswith("its grabbing process failed: ValueError: A frame has 640 x 200")


@pytest.mark.parametrize(
    ("module", "absent"),
    [
        ("drivers.marker_camera.device", ("cv2", "numpy", "numba")),
        ("drivers.marker_camera.process", ("cv2", "numpy", "numba")),
        ("drivers.sim.camera.wiring", ("cv2", "numba")),
        ("drivers.sim.camera.imageless", ("cv2", "numba")),
    ],
)
def test_loops_process_imports_nothing_heavy(module, absent):
    program = f"import sys; sys.path[:] = {[*sys.path]!r}; import {module}; print(*sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert not set(absent) & set(result.stdout.split())
