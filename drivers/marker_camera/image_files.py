"""Recordings as sources: a video file, a folder of images."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import cv2

from drivers.marker_camera.image_source import (
    CameraImage,
    Image,
    RecordingEnded,
    SourceFailure,
    to_grey,
)
from drivers.marker_camera.settings import MarkerCameraSettings
from rig.hal import Clock, ConfigurationError
from rig.hal.image_files import check_video, read_grey

_IMAGES: Final = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".tif", ".tiff"})


class RecordingSource:
    """A recording, played at its frame rate or as fast as its frames are taken.

    Frame k was exposed k frames after the recording was opened, and comes `latency` later.

    Parameters
    ----------
    settings : MarkerCameraSettings
        Path, pace, size, rate, latency.
    clock : Clock
        Paces it.
    play : callable
        ``play(path)``: an iterator over the images of a recording, in grey.
    """

    def __init__(
        self,
        settings: MarkerCameraSettings,
        clock: Clock,
        play: Callable[[Path], Iterator[Image]],
    ) -> None:
        self.serial: str | None = None
        self._settings = settings
        self._clock = clock
        self._play = play
        self._path = Path(settings.source.path)
        self._images: Iterator[Image] | None = None
        self._first: Image | None = None
        self._number = -1
        self._start = 0.0

    def open(self) -> None:
        """Read the first image and start the recording's time.

        Raises
        ------
        SourceFailure
            The recording is not there, cannot be read, is empty, or of another size.
        """
        if not self._path.exists():
            raise SourceFailure("there is no such recording", object=str(self._path))
        self._images = self._play(self._path)
        self._first = next(self._images, None)
        if self._first is None:
            raise SourceFailure("the recording has no frames", object=str(self._path))
        height, width = self._first.shape
        settings = self._settings
        if (width, height) != (settings.width, settings.height):
            raise SourceFailure(
                "the recording's images are not of the size that the lens was calibrated for",
                object=str(self._path),
                value=f"{width} x {height} pixels",
                bound=f"{settings.width} x {settings.height} pixels",
            )
        self.serial = read_recorded_serial(self._path)
        self._number = -1
        self._start = self._clock.now()

    def read(self) -> CameraImage:
        """Return the next image, when it is due.

        Raises
        ------
        RecordingEnded
            There are no more.
        """
        image = self._next()
        self._number += 1
        settings = self._settings
        t = self._start + self._number / settings.frame_rate
        if settings.source.paced:
            self._clock.sleep_until(t + settings.latency)
        return CameraImage(image, self._number, t)

    def close(self) -> None:
        """Release the file. Idempotent."""
        self._images = self._first = None

    def _next(self) -> Image:
        assert self._images is not None
        image, self._first = self._first, None
        if image is None:
            image = next(self._images, None)
        if image is None and self._settings.source.repeat:
            self._images = self._play(self._path)
            image = next(self._images, None)
        if image is None:
            raise RecordingEnded(
                "the recording has ended",
                object=str(self._path),
                value=f"{self._number + 1} frames",
            )
        return image


def video_frames(path: Path) -> Iterator[Image]:
    """Yield the frames of a video file in grey.

    Raises
    ------
    SourceFailure
        It is not a video that this OpenCV can read.
    """
    try:
        check_video(path)
    except ConfigurationError as error:
        raise SourceFailure(str(error), object=str(path)) from error
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    try:
        if not capture.isOpened():
            raise SourceFailure("it is not a video that can be read", object=str(path))
        while True:
            good, image = capture.read()
            if not good:
                return
            yield to_grey(image)
    finally:
        capture.release()


def folder_images(path: Path) -> Iterator[Image]:
    """Yield the images of a folder in grey, in the order of their names.

    Raises
    ------
    SourceFailure
        It is not a folder, or a file is not an image.
    """
    if not path.is_dir():
        raise SourceFailure("it is not a folder of images", object=str(path))
    for file in sorted(path.iterdir()):
        if file.suffix.lower() not in _IMAGES:
            continue
        try:
            image = read_grey(file)
        except ConfigurationError as error:
            raise SourceFailure(str(error), object=str(file)) from error
        if image is None:
            raise SourceFailure("a file is not an image", object=str(file))
        yield to_grey(image)


def read_recorded_serial(path: Path) -> str | None:
    """Return the serial number that was noted beside a recording, if any.

    The note is a text file: ``NAME.serial`` beside a video, ``camera.serial`` in a folder.
    """
    note = path / "camera.serial" if path.is_dir() else path.with_suffix(".serial")
    return note.read_text().strip() or None if note.is_file() else None
