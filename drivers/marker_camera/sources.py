"""Where frames come from: a camera of the operating system, a video file, a folder of images.

They run in the process that grabs and detects, so they may block.
"""

from drivers.marker_camera.image_files import RecordingSource, folder_images, video_frames
from drivers.marker_camera.image_source import FrameSource
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.uvc import UvcSource
from rig.hal import Clock


def open_source(settings: MarkerCameraSettings, clock: Clock) -> FrameSource:
    """Return the source that the settings name, not yet opened."""
    kind = settings.source.kind
    if kind == "uvc":
        return UvcSource(settings, clock)
    return RecordingSource(settings, clock, video_frames if kind == "video" else folder_images)
