"""What a source of frames is: one small protocol, and how it says that it cannot."""

from typing import Any, NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]


class SourceFailure(Exception):
    """A source cannot give frames; the driver, which has a name, makes a `DeviceError` of it.

    Parameters
    ----------
    what : str
        One sentence without the device's name.
    object, value, bound : str, optional
        As in `rig.hal.DeviceError`.
    """

    def __init__(
        self,
        what: str,
        *,
        object: str | None = None,
        value: str | None = None,
        bound: str | None = None,
    ) -> None:
        super().__init__(what)
        self.what = what
        self.object = object
        self.value = value
        self.bound = bound


class RecordingEnded(SourceFailure):
    """A recording has no more frames."""


class CameraImage(NamedTuple):
    """One image.

    Attributes
    ----------
    image : ndarray of uint8, shape (height, width)
    number : int
        In the stream; a gap is a dropped frame.
    t : float
        Middle of the exposure, s on the rig's clock.
    """

    image: Image
    number: int
    t: float


class FrameSource(Protocol):
    """Something that gives frames."""

    serial: str | None
    """The camera's serial number, if it is known once opened."""

    def open(self) -> None:
        """Start.

        Raises
        ------
        SourceFailure
            It is not there, or not as the settings say.
        """

    def read(self) -> CameraImage:
        """Wait for the next frame.

        Raises
        ------
        SourceFailure
            There is none, and there will be none.
        """

    def close(self) -> None:
        """Release it. Idempotent."""


def to_grey(image: Any) -> Image:
    """Return a grey image: of colours their brightness, of YUYV its first channel."""
    if image.ndim == 3 and image.shape[2] == 3:
        image = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    elif image.ndim == 3:
        image = image[:, :, 0]
    return np.ascontiguousarray(image, np.uint8)
