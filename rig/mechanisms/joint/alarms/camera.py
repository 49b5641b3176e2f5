"""Tell what is wrong when camera and encoders do not agree on the marker.

Wires cannot tell opposite encoders that are swapped from right ones: the mirrored pose fits them as
well. A camera can, before anything has moved, unless the ring is so near to upright that its
mirrored place is within the permitted distance.
"""

import math
from collections import deque
from collections.abc import Sequence

from controllers.spherical_joint.poses import Vector
from controllers.spherical_joint.types import CameraSample
from rig.hal import SafetyError
from rig.mechanisms.joint.alarms.settings import TwistAlarm

_HISTORY = 256
"""So many poses are remembered: a second at 1 kHz; older samples are not compared."""
_MIRRORED = 0.5
"""A mirrored pose explains the camera if it leaves less than this share of the distance."""
_MOVED = 3.0
"""The joint has moved once the marker went further than this many permitted distances."""


class MarkerWatch:
    """Compares each sample with where the encoders put the marker at its exposure.

    Parameters
    ----------
    device : str
        The camera's name, for messages.
    limit : float
        How far the two may differ, m.
    grace : float
        For how long they may differ more, s.
    twist : TwistAlarm
        How far the ring may be turned about its axis.
    encoders : sequence of str
        Names of those of ch1 … ch4, for messages: ch1 and ch3 move the marker along y, ch2 and
        ch4 along x.
    """

    def __init__(
        self,
        device: str,
        limit: float,
        grace: float,
        twist: TwistAlarm,
        encoders: Sequence[str],
    ) -> None:
        self._device = device
        self._encoders = tuple(encoders)
        self._limit = limit
        self._grace = grace
        self._twist = twist
        self._history: deque[tuple[float, Vector]] = deque(maxlen=_HISTORY)
        self._seen = -math.inf
        self._alike_at: float | None = None
        self._straight_at: float | None = None
        self._travelled = 0.0

    def take(self, marker: Vector, now: float) -> None:
        """Take where the encoders put the marker now, m."""
        if self._history:
            self._travelled = max(self._travelled, math.dist(marker, self._history[0][1]))
        self._history.append((now, marker))

    def check(self, sample: CameraSample) -> None:
        """Raise if the camera has seen the marker elsewhere for too long.

        Raises
        ------
        SafetyError
            It has; the likeliest cause is named.
        """
        if sample.t <= self._seen:
            return
        then = self._at(sample.t)
        if then is None:
            return
        self._seen = sample.t
        distance = math.dist(then, sample.marker)
        if distance <= self._limit or self._alike_at is None:
            # The first sample counts as seen alike, so that a wrong one gets its grace as well.
            self._alike_at = sample.t
        if sample.t - self._alike_at > self._grace:
            raise SafetyError(
                f"{self._device}: {self._explain(then, sample.marker)} [the marker is "
                f"{distance * 1e3:.1f} mm from where the encoders put it for "
                f"{sample.t - self._alike_at:.3f} s, at most {self._limit * 1e3:g} mm for "
                f"{self._grace:g} s]"
            )

    def check_twist(self, twist: float, t: float) -> None:
        """Raise if the ring has been turned about its axis for too long.

        Parameters
        ----------
        twist : float
            Beyond the shortest tilt from home, as the camera sees it, rad.
        t : float
            When, s.

        Raises
        ------
        SafetyError
            It has.
        """
        settings = self._twist
        if abs(twist) <= settings.limit or self._straight_at is None:
            self._straight_at = t
        if t - self._straight_at > settings.time:
            raise SafetyError(
                f"{self._device}: the ring is twisted, or the marker is mounted so [twist "
                f"{math.degrees(twist):+.1f} deg for {t - self._straight_at:.3f} s, at most "
                f"{math.degrees(settings.limit):g} deg either way for {settings.time:g} s]"
            )

    def _at(self, t: float) -> Vector | None:
        """Return where the encoders put the marker at a time, m; None if it is not known."""
        later, after = math.inf, None
        for earlier, before in reversed(self._history):
            if earlier <= t:
                if after is None:
                    return before
                share = (t - earlier) / (later - earlier)
                return (
                    before[0] + share * (after[0] - before[0]),
                    before[1] + share * (after[1] - before[1]),
                    before[2] + share * (after[2] - before[2]),
                )
            later, after = earlier, before
        return None

    def _explain(self, encoders: Vector, camera: Vector) -> str:
        if self._travelled <= _MOVED * self._limit:
            swapped = self._swapped(encoders, camera)
            return swapped or (
                "it is not where the joint is calibrated to be before anything has moved: another "
                "rig's calibration, a moved camera or another marker"
            )
        x, y, z = camera
        for seen, what in (  # encoders that were swapped would have been found by their work
            ((-x, y, z), "the image is mirrored left to right"),
            ((x, -y, z), "the image is mirrored top to bottom"),
            ((-x, -y, z), "the image is upside down"),
            ((-y, x, z), "the image is turned by a quarter"),
            ((y, -x, z), "the image is turned by a quarter"),
        ):
            if math.dist(encoders, seen) < self._limit:
                return what
        return (
            "another marker is followed, the camera was moved, an anchor has slipped, or the ring "
            "is pushed"
        )

    def _swapped(self, encoders: Vector, camera: Vector) -> str | None:
        """Return which opposite encoders would explain it that nothing agrees from the start."""
        first, second, third, fourth = self._encoders
        bound = min(self._limit, _MIRRORED * math.dist(encoders, camera))
        x, y, z = encoders
        for mirrored, names in (
            ((x, -y, z), f"{first} and {third} are"),
            ((-x, y, z), f"{second} and {fourth} are"),
            ((-x, -y, z), f"{first} and {third}, and {second} and {fourth}, are"),
        ):
            if math.dist(mirrored, camera) < bound:
                return f"{names} swapped, or the image is mirrored, before anything has moved"
        return None
