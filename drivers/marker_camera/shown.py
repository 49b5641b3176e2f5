"""Frames for whoever looks on: small, compressed, and only while somebody does."""

import contextlib
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Final

from drivers.marker_camera.sighting import Sighting
from rig.hal.pictures import PictureFile, Snapshot

if TYPE_CHECKING:
    from drivers.marker_camera.image_source import Image
    from drivers.marker_camera.projection import Point

_PERIOD: Final = 0.1
"""Between two pictures at least, s."""
_WIDTH: Final = 640
"""Pixels of a picture at most."""
_QUALITY: Final = 60


def offer_pictures(path: Path) -> Path | None:
    """Make the file for pictures; None if that cannot be: nobody needs them for a run."""
    try:
        PictureFile(path, create=True).close()
    except OSError:
        return None
    return path


class ShownFrames:
    """Puts a frame into the file now and then, if it is asked for.

    Parameters
    ----------
    path : Path, optional
        The file; None, or one that is not there any more: nobody can ask.
    """

    def __init__(self, path: Path | None) -> None:
        self._file: PictureFile | None = None
        self._due = 0.0
        if path is not None:
            with contextlib.suppress(OSError, ValueError):  # a run needs no pictures
                self._file = PictureFile(path)

    def offer(self, image: "Image", sighting: Sighting, places: "Sequence[Point]") -> None:
        """Show a frame, with the markers that were found in it, unless nobody looks on.

        Parameters
        ----------
        image : ndarray of uint8, shape (height, width)
            The frame that was searched.
        sighting : Sighting
            What came of it.
        places : sequence of tuple of float
            Where the markers were, pixels.
        """
        if self._file is None:
            return
        try:
            if self._file.is_wanted() and monotonic() >= self._due:
                self._due = monotonic() + _PERIOD
                self._file.put(_snapshot_of(image, sighting, places))
        except OSError:
            self.close()  # whatever the disk has: the camera goes on

    def close(self) -> None:
        """Let go of the file. Idempotent."""
        if self._file is not None:
            self._file.close()
            self._file = None


def _snapshot_of(image: "Image", sighting: Sighting, places: "Sequence[Point]") -> Snapshot:
    import cv2

    height, width = image.shape
    small = image
    if width > _WIDTH:
        size = _WIDTH, max(round(height * _WIDTH / width), 1)
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype("uint8", copy=False)
    _, jpeg = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    verdict = sighting.sight.name.lower()
    return Snapshot(sighting.frame, width, height, verdict, tuple(places), jpeg.tobytes())
