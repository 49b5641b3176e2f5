"""A camera of the operating system, through OpenCV."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, Protocol

import cv2

from drivers.marker_camera.image_source import CameraImage, SourceFailure, to_grey
from drivers.marker_camera.settings import MarkerCameraSettings
from rig.hal import Clock
from rig.hal.device_files import device_trouble

_MANUAL: Final = 1.0
"""V4L2_EXPOSURE_MANUAL of the control V4L2_CID_EXPOSURE_AUTO."""

_EXPOSURE_UNIT: Final = 1e-4
"""Of V4L2_CID_EXPOSURE_ABSOLUTE, s."""

_MOST_QUEUED: Final = 4
"""Frames that the operating system keeps at most."""

_STAMP_AGE: Final = 1.0
"""A time stamp further in the past is not of the monotonic clock, s."""


class Capture(Protocol):
    """The part of `cv2.VideoCapture` that is needed."""

    def isOpened(self) -> bool: ...  # noqa: D102, N802
    def set(self, propId: int, value: float) -> bool: ...  # noqa: D102
    def get(self, propId: int) -> float: ...  # noqa: D102
    def grab(self) -> bool: ...  # noqa: D102
    def retrieve(self) -> tuple[bool, Any]: ...  # noqa: D102
    def release(self) -> None: ...  # noqa: D102


class UvcSource:
    """A camera of the operating system (Video4Linux), at fixed exposure, newest frame first.

    Parameters
    ----------
    settings : MarkerCameraSettings
        Device, size, rate, exposure, latency.
    clock : Clock
        Monotonic: the kernel stamps buffers with the same one.
    open_capture : callable, optional
        Opens a device; OpenCV's Video4Linux capture.
    """

    def __init__(
        self,
        settings: MarkerCameraSettings,
        clock: Clock,
        open_capture: Callable[[str], Capture] | None = None,
    ) -> None:
        self.serial: str | None = None
        self._settings = settings
        self._clock = clock
        path = str(settings.source.path)
        self._path = f"/dev/video{path}" if path.isdecimal() else path
        self._open_capture = open_capture or _open_v4l2
        self._capture: Capture | None = None
        self._number = -1
        self._arrival = 0.0

    def open(self) -> None:
        """Open the device, set size, rate and exposure, and read them back.

        Raises
        ------
        SourceFailure
            There is no such camera, or it did not take a setting.
        """
        settings = self._settings
        capture = self._open_capture(self._path)
        self._capture = capture
        if not capture.isOpened():
            trouble = device_trouble(Path(self._path))
            why = f": {trouble}" if trouble else ""
            raise SourceFailure(f"there is no camera at its path{why}", object=self._path)
        wanted = settings.source.pixel_format
        capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*wanted[:4]))
        if wanted in ("GREY", "YUYV"):
            capture.set(cv2.CAP_PROP_CONVERT_RGB, 0.0)  # the first channel is all that is needed
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1.0)
        self._set(cv2.CAP_PROP_FRAME_WIDTH, settings.width, "image width", "pixels")
        self._set(cv2.CAP_PROP_FRAME_HEIGHT, settings.height, "image height", "pixels")
        self._set(cv2.CAP_PROP_FPS, settings.frame_rate, "frame rate", "Hz", tolerance=0.02)
        self._set(cv2.CAP_PROP_AUTO_EXPOSURE, _MANUAL, "exposure mode (1: manual)", "")
        # Steps are whole multiples of the unit, and cameras round to their own.
        self._set(
            cv2.CAP_PROP_EXPOSURE,
            settings.exposure / _EXPOSURE_UNIT,
            "exposure time",
            "x 100 µs",
            tolerance=0.2,
        )
        self.serial = read_usb_serial(self._path)
        self._arrival = self._clock.now()

    def read(self) -> CameraImage:
        """Wait for a frame; those that queued up meanwhile are dropped.

        Raises
        ------
        SourceFailure
            The camera stopped sending.
        """
        capture = self._capture
        assert capture is not None
        settings = self._settings
        missed = int((self._clock.now() - self._arrival) * settings.frame_rate) - 1
        for _ in range(1 + min(max(missed, 0), _MOST_QUEUED)):
            if not capture.grab():
                raise self._lost()
            self._number += 1
        self._arrival = now = self._clock.now()
        stamp = 1e-3 * capture.get(cv2.CAP_PROP_POS_MSEC)
        if not now - _STAMP_AGE < stamp <= now:
            stamp = now  # this driver of the kernel does not stamp with the monotonic clock
        good, image = capture.retrieve()
        if not good or image is None:
            raise self._lost()
        return CameraImage(to_grey(image), self._number, stamp - settings.latency)

    def close(self) -> None:
        """Release the device. Idempotent."""
        if self._capture is not None:
            self._capture.release()
        self._capture = None

    def _set(
        self, control: int, value: float, what: str, unit: str, *, tolerance: float = 0.0
    ) -> None:
        assert self._capture is not None
        self._capture.set(control, float(value))
        taken = self._capture.get(control)
        if abs(taken - value) > tolerance * abs(value):
            raise SourceFailure(
                f"the camera did not take the {what}",
                object=self._path,
                value=f"{taken:g} {unit}".rstrip(),
                bound=f"{value:g} {unit}".rstrip(),
            )

    def _lost(self) -> SourceFailure:
        return SourceFailure(
            "the camera stopped sending frames; it was unplugged or lost its power",
            object=self._path,
            value=f"{self._number + 1} frames",
        )


def read_usb_serial(device: str, root: Path = Path("/sys/class/video4linux")) -> str | None:
    """Return the USB serial number of a camera, if it has one.

    Parameters
    ----------
    device : str
        ``/dev/videoN``, or a link to it.
    root : Path
        Where the kernel lists cameras.
    """
    # The entry's `device` is the USB interface; its parent is the device with the number.
    interface = root / Path(device).resolve().name / "device"
    note = interface.resolve().parent / "serial"
    return note.read_text().strip() or None if note.is_file() else None


def _open_v4l2(path: str) -> Capture:
    return cv2.VideoCapture(path, cv2.CAP_V4L2)
