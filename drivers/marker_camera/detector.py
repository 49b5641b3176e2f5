"""From frames to sightings: search where the marker should be, else everywhere."""

import zlib
from math import nan
from typing import Final, NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.marker_camera.aruco import SquareFinder, meet_diagonals
from drivers.marker_camera.blob import compute_histogram, find_largest_blob, split_levels
from drivers.marker_camera.projection import Point, Vector3, View
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.sighting import Sight, Sighting

Image = NDArray[np.uint8]

_CANDIDATES: Final = 4
"""How many regions of a whole frame are looked at more closely."""

_ROWS: Final = 32
"""Every so many rows make the fingerprint that tells one image from the next."""


class SearchResult(NamedTuple):
    """The result of a search; see `Sighting`. `places` are the markers' centres, pixels."""

    sight: Sight
    amount: float = nan
    ids: tuple[int, ...] = ()
    positions: tuple[Vector3, ...] = ()
    twists: tuple[float, ...] = ()
    places: tuple[Point, ...] = ()


class Search(Protocol):
    """A way to find markers of one kind."""

    def look_at(self, image: Image, x0: int, y0: int) -> SearchResult:
        """Search a region whose top left pixel is (`x0`, `y0`) of the frame."""

    def acquire(self, image: Image) -> tuple[SearchResult, list[Point]]:
        """Search a whole frame coarsely: what to say if nothing is found, and where to look."""


class BlobSearch:
    """Finds the disc of the settings.

    Parameters
    ----------
    settings : MarkerCameraSettings
        Marker, thresholds, lens and pose.
    """

    def __init__(self, settings: MarkerCameraSettings) -> None:
        self._settings = settings
        self._view = View(settings)
        self._radius = 0.5 * settings.marker.diameter
        self._bright = settings.marker.polarity == "bright"
        top = (0.0, 0.0, settings.marker.sphere_radius)
        self._home_area = max(self._view.disc_area(top, self._radius), 16.0)
        # A disc keeps some eight pixels across in the thinned image of a search.
        self._stride = max(1, int(self._home_area**0.5 / 8.0))

    def look_at(self, image: Image, x0: int, y0: int) -> SearchResult:
        """Search a region whose top left pixel is (`x0`, `y0`) of the frame."""
        settings = self._settings
        if not self._bright:
            image = cv2.bitwise_not(image).astype(np.uint8, copy=False)
        split = split_levels(compute_histogram(image))
        if split.contrast < settings.min_contrast:
            return SearchResult(Sight.LOST, split.contrast)
        blob = find_largest_blob(image, split.threshold)
        if blob is None or blob.cut:
            return SearchResult(Sight.LOST, split.contrast)
        place = (x0 + blob.x, y0 + blob.y)
        position = self._view.locate_disc(place, self._radius)
        if position is None:
            return SearchResult(Sight.OUTSIDE, place[0])
        expected = self._view.disc_area(position, self._radius)
        if abs(blob.area - expected) > settings.marker.area_tolerance * expected:
            diameter = settings.marker.diameter * (blob.area / max(expected, 1e-9)) ** 0.5
            return SearchResult(Sight.SWAPPED, diameter)
        return SearchResult(Sight.SEEN, nan, settings.marker.ids[:1], (position,), (nan,), (place,))

    def acquire(self, image: Image) -> tuple[SearchResult, list[Point]]:
        """Search a whole frame coarsely: what to say if nothing is found, and where to look.

        A disc is so small a part of a frame that Otsu's threshold may split the background
        instead; the level that a fraction of the disc's own pixels reach does not.
        """
        stride = self._stride
        thin = np.ascontiguousarray(image[::stride, ::stride])
        if not self._bright:
            thin = 255 - thin
        below = np.cumsum(compute_histogram(thin))
        pixels = below[-1]
        background = int(np.searchsorted(below, 0.5 * pixels))
        few = 0.1 * self._home_area / stride**2
        level = int(np.searchsorted(below, pixels - max(few, 1.0)))
        contrast = float(level - background)
        if contrast < self._settings.min_contrast:
            return SearchResult(Sight.LOST, contrast), []
        mask = cv2.threshold(thin, (level + background) // 2, 255, cv2.THRESH_BINARY)[1]
        _, _, stats, centroids = cv2.connectedComponentsWithStats(mask, connectivity=8)
        largest = np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable")[:_CANDIDATES] + 1
        places = [
            (float(centroids[k, 0]) * stride, float(centroids[k, 1]) * stride) for k in largest
        ]
        return SearchResult(Sight.LOST, contrast), places


class ArucoSearch:
    """Finds the ArUco markers of the settings."""

    def __init__(self, settings: MarkerCameraSettings) -> None:
        self._view = View(settings)
        self._finder = SquareFinder(settings.marker.dictionary)
        self._known = frozenset(settings.marker.ids)
        distance = sum(x * x for x in settings.position_camera_in_base) ** 0.5
        side = settings.marker.side * settings.intrinsics.fx / distance
        # A marker keeps some forty pixels in the reduced image of a search, half of that tilted.
        self._scale = max(1, int(side / 40.0))

    def look_at(self, image: Image, x0: int, y0: int) -> SearchResult:
        """Search a region whose top left pixel is (`x0`, `y0`) of the frame."""
        squares = self._finder.find(image)
        ids, positions, twists, places = [], [], [], []
        for square in squares:
            if square.number not in self._known:
                continue
            corners = [self._view.undistort((x0 + x, y0 + y)) for x, y in square.corners]
            position = self._view.meet_sphere(meet_diagonals(corners))
            if position is None:
                return SearchResult(Sight.OUTSIDE, x0 + square.corners[0][0])
            twist = self._view.twist(position, corners)
            ids.append(square.number)
            positions.append(position)
            twists.append(nan if twist is None else twist)
            places.append(self._view.project(position))
        if ids:
            return SearchResult(
                Sight.SEEN, nan, tuple(ids), tuple(positions), tuple(twists), tuple(places)
            )
        if squares:
            return SearchResult(Sight.SWAPPED, float(squares[0].number))
        return SearchResult(Sight.LOST, split_levels(compute_histogram(image)).contrast)

    def acquire(self, image: Image) -> tuple[SearchResult, list[Point]]:
        """Search a whole frame coarsely: what to say if nothing is found, and where to look."""
        scale = self._scale
        if scale > 1:
            small = cv2.resize(
                image, None, fx=1 / scale, fy=1 / scale, interpolation=cv2.INTER_AREA
            )
            image = small.astype(np.uint8, copy=False)
        squares = self._finder.find(image)
        if not squares:
            mirrored = self._finder.find_mirrored(image)
            if mirrored:
                return SearchResult(Sight.MIRRORED, float(mirrored[0])), []
            contrast = split_levels(compute_histogram(image)).contrast
            return SearchResult(Sight.LOST, contrast), []
        centres = [meet_diagonals(square.corners) for square in squares]
        places = [((x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5) for x, y in centres]
        return SearchResult(Sight.SWAPPED, float(squares[0].number)), places


class MarkerDetector:
    """Turns the frames of one stream into sightings.

    A marker that was seen is expected where it would be at the speed that it had; the region
    round that place is searched first, a whole frame only if that fails.
    """

    def __init__(self, settings: MarkerCameraSettings) -> None:
        self._settings = settings
        blob = settings.marker.kind == "blob"
        self._search: Search = BlobSearch(settings) if blob else ArucoSearch(settings)
        self._place: Point | None = None
        self._step: Point = (0.0, 0.0)
        self._frame = 0
        self._fingerprint = 0
        self._identical = 1
        self.searches = 0
        """How many whole frames were searched."""
        self.places: tuple[Point, ...] = ()
        """Where the markers of the last frame were, pixels."""

    def detect(self, image: Image, frame: int, t: float) -> Sighting:
        """Return what a frame shows.

        Parameters
        ----------
        image : ndarray of uint8, shape (height, width)
            The frame.
        frame : int
            Its number in the stream.
        t : float
            Middle of its exposure, s.

        Raises
        ------
        ValueError
            The image is not of the size that the settings say.
        """
        settings = self._settings
        if image.shape != (settings.height, settings.width):
            raise ValueError(
                f"A frame has {image.shape[1]} x {image.shape[0]} pixels; the lens was calibrated "
                f"for {settings.width} x {settings.height}."
            )
        identical = self._count_identical(image)
        if identical >= settings.max_identical and float(image.mean()) >= settings.dark_level:
            self._place, self.places = None, ()
            return Sighting(frame, t, Sight.FROZEN, amount=float(identical))
        outcome = self._look(image, frame)
        self._follow(outcome, frame)
        self.places = outcome.places
        return Sighting(
            frame,
            t,
            outcome.sight,
            outcome.ids,
            outcome.positions,
            outcome.twists,
            outcome.amount,
        )

    def _look(self, image: Image, frame: int) -> SearchResult:
        if self._place is not None:
            frames = frame - self._frame
            x, y = self._place
            dx, dy = self._step
            outcome = self._look_round(image, (x + frames * dx, y + frames * dy))
            if outcome.sight is Sight.SEEN:
                return outcome
        self.searches += 1
        mean = float(image.mean())
        if mean < self._settings.dark_level:
            return SearchResult(Sight.COVERED, mean)
        failed, places = self._search.acquire(image)
        seen = [self._look_round(image, place) for place in places]
        best = next((outcome for outcome in seen if outcome.sight is Sight.SEEN), None)
        if best is not None:
            return best
        return seen[0] if seen else failed

    def _look_round(self, image: Image, place: Point) -> SearchResult:
        side = self._settings.roi
        height, width = image.shape
        x0 = min(max(round(place[0]) - side // 2, 0), max(width - side, 0))
        y0 = min(max(round(place[1]) - side // 2, 0), max(height - side, 0))
        return self._search.look_at(image[y0 : y0 + side, x0 : x0 + side], x0, y0)

    def _follow(self, outcome: SearchResult, frame: int) -> None:
        if outcome.sight is not Sight.SEEN:
            self._place = None
            return
        x, y = outcome.places[0]
        frames = frame - self._frame
        if self._place is not None and frames > 0:
            self._step = ((x - self._place[0]) / frames, (y - self._place[1]) / frames)
        else:
            self._step = (0.0, 0.0)
        self._place, self._frame = (x, y), frame

    def _count_identical(self, image: Image) -> int:
        fingerprint = zlib.crc32(image[::_ROWS].tobytes())
        self._identical = self._identical + 1 if fingerprint == self._fingerprint else 1
        self._fingerprint = fingerprint
        return self._identical
