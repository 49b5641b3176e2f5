"""The driver of a marker camera."""

from collections.abc import Callable
from math import inf, isnan
from pathlib import Path
from typing import Final, NamedTuple

from drivers.marker_camera.link import CameraLink, Event, Failure, Ready
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.sighting import Sight, Sighting
from rig.hal import (
    Clock,
    ConnectionFailed,
    DeviceError,
    DeviceFault,
    MarkerCamera,
    Markers,
    Reading,
    StaleReading,
)
from rig.hal.pictures import SUFFIX, forget_picture

_POLL: Final = 1e-3
"""How often the link is asked while something is waited for, s."""

_NOTHING: Final = Markers((), ())


class Reason(NamedTuple):
    """The reason why a marker was not seen, in words; fields of `rig.hal.DeviceError`."""

    what: str
    value: str
    bound: str


class MarkerCameraDriver(MarkerCamera):
    """A camera that watches a marker; satisfies `rig.hal.MarkerCamera`.

    Parameters are those of every driver: see `rig.hal.parts.DriverParts`.
    """

    Settings = MarkerCameraSettings

    needs_bus = False
    """It brings its own way to the program."""

    def __init__(
        self,
        name: str,
        settings: MarkerCameraSettings,
        clock: Clock,
        *,
        serial: int | None = None,
        link: CameraLink | None = None,
    ) -> None:
        self.name = name
        self.settings = settings
        self._clock = clock
        self._serial = serial
        self._link = link or _open_process_link(settings)
        self._armed = False
        self._picture: Path | None = None
        self._forget()

    @property
    def sphere_radius(self) -> float:
        """How far from the joint's centre it takes the marker to be, m."""
        return self.settings.marker.sphere_radius

    @property
    def latency(self) -> float:
        """From the middle of the exposure to the sample, as calibrated, s."""
        return self.settings.latency

    # Life cycle -----------------------------------------------------------------------

    def show_in(self, folder: Path) -> None:
        """Let whoever looks on see what it sees, by a file of the run's folder."""
        self._picture = folder / f"{self.name}{SUFFIX}"
        self._link.show_in(self._picture)

    def connect(self) -> None:
        """Start grabbing and compare the camera's serial number.

        Raises
        ------
        ConnectionFailed
            There is no such source, it did not take a setting, or it is another camera than
            the one that the profile names or that was calibrated.
        """
        self._armed = False
        self._forget()
        self._link.open(self._clock.now())
        timeout = self.settings.connect_timeout
        if not self._wait_for(lambda: self._ready is not None or self._failure is not None):
            raise ConnectionFailed(
                self.name, "its source did not open in time", bound=f"{timeout:g} s"
            )
        if self._failure is not None:
            raise self._failed(ConnectionFailed, self._failure)
        assert self._ready is not None
        self._check_serial(self._ready.serial)

    def arm(self) -> None:
        """Wait until the marker is seen; a camera has nothing to energise.

        Raises
        ------
        ConnectionFailed
            No frame comes, or none shows the marker: the reason is named.
        """
        newest = self._newest
        since = self._clock.now() if newest is None else newest.t
        if not self._wait_for(lambda: self._has_seen(since) or self._failure is not None):
            timeout = self.settings.connect_timeout
            if self._newest is None:
                raise ConnectionFailed(self.name, "no frame came", bound=f"within {timeout:g} s")
            reason = explain(self._newest, self.settings)
            raise ConnectionFailed(self.name, reason.what, value=reason.value, bound=reason.bound)
        if self._failure is not None:
            raise self._failed(ConnectionFailed, self._failure)
        self._armed = True

    def make_safe(self) -> None:
        """Do nothing: a camera moves nothing."""

    def close(self) -> None:
        """End the grabbing. Idempotent."""
        self._armed = False
        self._link.close()
        forget_picture(self._picture)
        self._picture = None

    # The cycle ------------------------------------------------------------------------

    def markers(self) -> Reading[Markers]:
        """Return the newest frame's markers; `t` is the middle of its exposure."""
        self._take()
        return self._markers

    def twists(self) -> Reading[tuple[float, ...]]:
        """Return the twists of `markers`, rad, NaN for a marker that does not show it.

        Twist is the rotation about the marker's normal beyond the shortest rotation that takes
        the base frame's z axis there.
        """
        return self._twists

    def check(self, now: float) -> None:
        """Raise if the camera is not well.

        Raises
        ------
        DeviceFault
            It was unplugged, its process ended, its image is frozen, or the marker was out of
            sight for too long: covered lens, other marker, mirrored image.
        StaleReading
            The newest frame is older than `max_age`.
        """
        if self._failure is not None:
            raise self._failed(DeviceFault, self._failure)
        if not self._armed or self._newest is None:
            return
        settings, newest = self.settings, self._newest
        if newest.sight is Sight.FROZEN or newest.t - self._seen_at > settings.max_absence:
            reason = explain(newest, settings)
            absent = newest.t - self._seen_at
            raise DeviceFault(
                self.name,
                f"{reason.what}; the marker was last seen {absent:.3f} s ago",
                value=reason.value,
                bound=f"{reason.bound}, unseen at most {settings.max_absence:g} s",
            )
        age = now - newest.t
        if age > settings.max_age:
            raise StaleReading(self.name, age, settings.max_age)

    # Inside ---------------------------------------------------------------------------

    def _forget(self) -> None:
        self._ready: Ready | None = None
        self._failure: Failure | None = None
        self._newest: Sighting | None = None
        self._seen_at = -inf
        self._markers: Reading[Markers] = Reading(_NOTHING, -inf)
        self._twists: Reading[tuple[float, ...]] = Reading((), -inf)

    def _take(self) -> None:
        for event in self._link.poll(self._clock.now()):
            self._take_event(event)

    def _take_event(self, event: Event) -> None:
        if isinstance(event, Failure):
            self._failure = self._failure or event
        elif isinstance(event, Ready):
            self._ready = event
        else:
            self._take_sighting(event)

    def _take_sighting(self, sighting: Sighting) -> None:
        self._newest = sighting
        twists = () if any(map(isnan, sighting.twists)) else sighting.twists
        self._markers = Reading(Markers(sighting.ids, sighting.positions, twists), sighting.t)
        self._twists = Reading(sighting.twists, sighting.t)
        if sighting.sight is Sight.SEEN:
            self._seen_at = sighting.t

    def _wait_for(self, done: Callable[[], bool]) -> bool:
        """Take events until something is true; False if the time for it is over."""
        clock = self._clock
        until = clock.now() + self.settings.connect_timeout
        while True:
            self._take()
            if done():
                return True
            if clock.now() >= until:
                return False
            clock.sleep_until(clock.now() + _POLL)

    def _has_seen(self, since: float) -> bool:
        newest = self._newest
        return newest is not None and newest.sight is Sight.SEEN and newest.t >= since

    def _check_serial(self, found: str | None) -> None:
        named = None if self._serial is None else str(self._serial)
        calibrated = self.settings.calibrated_serial
        for wanted, whose in ((named, "the profile names"), (calibrated, "was calibrated")):
            if wanted is not None and not _is_same_serial(found, wanted):
                raise ConnectionFailed(
                    self.name,
                    f"it is another camera than the one that {whose}",
                    object="serial number",
                    value=found or "none",
                    bound=wanted,
                )

    def _failed(self, kind: type[DeviceError], failure: Failure) -> DeviceError:
        return kind(
            self.name,
            failure.what,
            object=failure.object,
            value=failure.value,
            bound=failure.bound,
        )


def explain(sighting: Sighting, settings: MarkerCameraSettings) -> Reason:
    """Return why a frame does not show the marker, with the number and its bound."""
    marker, amount = settings.marker, sighting.amount
    if sighting.sight is Sight.COVERED:
        return Reason(
            "the image is dark: the lens is covered or the lamp is off",
            f"mean {amount:.1f} counts",
            f"at least {settings.dark_level:g} counts",
        )
    if sighting.sight is Sight.SWAPPED and marker.kind == "blob":
        return Reason(
            "another disc than the marker is in view",
            f"diameter {amount:.3g} m",
            f"{marker.diameter:g} m",
        )
    if sighting.sight is Sight.SWAPPED:
        known = ", ".join(str(number) for number in marker.ids)
        return Reason("another marker is in view", f"number {amount:.0f}", f"number {known}")
    if sighting.sight is Sight.MIRRORED:
        return Reason(
            "the image is mirrored: the marker is in mirror writing",
            f"number {amount:.0f} mirrored",
            f"number {', '.join(str(number) for number in marker.ids)} as printed",
        )
    if sighting.sight is Sight.OUTSIDE:
        return Reason(
            "what is seen is not on the marker's sphere",
            f"x {amount:.1f} pixels",
            f"a sphere of {marker.sphere_radius:g} m",
        )
    if sighting.sight is Sight.FROZEN:
        return Reason(
            "its image is frozen",
            f"{amount:.0f} equal images in a row",
            f"fewer than {settings.max_identical}",
        )
    contrast = "none" if isnan(amount) else f"contrast {amount:.1f} counts"
    return Reason("the marker is out of sight", contrast, f"{settings.min_contrast:g} counts")


def _is_same_serial(found: str | None, wanted: str) -> bool:
    """Return whether two serial numbers are the same, whatever zeros they start with."""
    return found is not None and found.lstrip("0") == wanted.lstrip("0")


def _open_process_link(settings: MarkerCameraSettings) -> CameraLink:
    from drivers.marker_camera.process import ProcessLink

    return ProcessLink(settings)
