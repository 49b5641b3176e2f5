"""A short recorded sequence: the marker draws the 20 degree circle once, in 40 frames.

``python tests/unit/camera/camera_recording.py`` writes it again as ``tests/data/marker-circle.avi``
(motion JPEG). The tests replay that file, and check that it is still what this script makes.
"""

import math
from pathlib import Path

import cv2
from camera_scenes import pose

from drivers.marker_camera.settings import IntrinsicsSettings, MarkerCameraSettings, SourceSettings
from drivers.sim.camera.renderer import MarkerRenderer
from drivers.sim.camera.settings import CameraSimulationSettings

FILE = Path(__file__).parents[2] / "data" / "marker-circle.avi"
FRAMES = 40
TILT = math.radians(20.0)
OPTICS = CameraSimulationSettings(read_noise=1.0, shot_noise=0.01)


def recorded(path, kind="video", **source):
    """The settings with which the recording is replayed."""
    return MarkerCameraSettings(
        source=SourceSettings(kind=kind, path=str(path), **source),
        width=640,
        height=512,
        intrinsics=IntrinsicsSettings(fx=1666.0, fy=1666.0, cx=319.5, cy=255.5, k1=-0.05),
        roi=128,
        connect_timeout=60.0,  # a loaded machine may take long to start a process,
        max_age=60.0,  # and to come back to it
    )


def true_pose(frame):
    return pose(TILT, 2 * math.pi * frame / FRAMES)


def render_frames(frames=FRAMES):
    renderer = MarkerRenderer(recorded("-"), OPTICS, 1)
    return [renderer.render([true_pose(k)]) for k in range(frames)]


def write_video(path, images, codec="MJPG"):
    height, width = images[0].shape
    writer = cv2.VideoWriter(
        str(path),
        cv2.CAP_FFMPEG,
        cv2.VideoWriter.fourcc(*codec),
        60.0,
        (width, height),
        isColor=False,
    )
    assert writer.isOpened()
    for image in images:
        writer.write(image)
    writer.release()
    return path


def write_images(folder, images):
    folder.mkdir(exist_ok=True)
    for k, image in enumerate(images):
        assert cv2.imwrite(str(folder / f"frame-{k:04d}.png"), image)
    return folder


if __name__ == "__main__":
    FILE.parent.mkdir(exist_ok=True)
    write_video(FILE, render_frames())
