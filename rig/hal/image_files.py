"""Images and videos that somebody else may have made: none can hang the program or fill it."""

from pathlib import Path
from typing import TYPE_CHECKING, Final

from rig.hal.files import open_regular, read_regular

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_MOST: Final = 1 << 28
"""Bytes of a file."""


def read_grey(path: Path) -> "NDArray[np.uint8] | None":
    """Return an image in grey, shape (height, width); None if it is none that can be read.

    Raises
    ------
    ConfigurationError
        It is not a regular file, or too large a one.
    """
    content = read_regular(path, _MOST)
    import cv2
    import numpy as np

    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
        return None if image is None else image.astype(np.uint8, copy=False)
    except cv2.error:  # no content, or more pixels than `rig` lets OpenCV read
        return None


def check_video(path: Path) -> None:
    """Raise unless OpenCV may open a video: it waits at a pipe, and reads what a device gives.

    Raises
    ------
    ConfigurationError
        It is not a regular file.
    """
    open_regular(path).close()
