"""What a rig may do that nobody has commissioned: a quarter of the speed, half of the effort."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, radians
from typing import Final

from rig.assembly import REGISTRY
from rig.config import Profile
from rig.experiment.excerpts import AnyMechanism
from rig.hal import DeviceError, DriverSettings
from rig.hal.motion import Motion, Segment

SPEED: Final = 0.25
"""Share of the speed."""
EFFORT: Final = 0.5
"""Share of pressure and torque."""


SLOW: Final = radians(6.0)
"""Greatest speed of axes that nobody has seen move yet, rad/s."""
CLOSE: Final = radians(0.4)
"""Greatest distance of such an axis from its setpoint, rad: twice what legs sag when energised."""


def derated(profile: Profile, *, is_first: bool = False) -> Profile:
    """Return a profile with limits for a rig that is not commissioned.

    Parameters
    ----------
    profile : Profile
        As it is.
    is_first : bool
        It is for the first motion of the acceptance test, which is slow and small by itself: of
        a mechanism that has no limits for slow motions the drives' torque alone is lowered.

    Raises
    ------
    DeviceError
        Nobody knows what the mechanism's limits would be then.
    """
    view = REGISTRY.load("mechanism", profile.mechanism)
    try:
        settings = view.derated(profile.mechanism_settings, EFFORT, SPEED)
    except ValueError as error:
        raise DeviceError(profile.name, f"with half of its effort: {error}") from error
    if settings is None:
        if not is_first:
            raise DeviceError(profile.name, f"a {profile.mechanism} has no limits for slow motions")
        settings = profile.mechanism_settings
    weak = replace(profile, mechanism_settings=settings)
    return _with_devices(weak, lambda its: its.gentle(inf, inf, EFFORT))


def gentle(profile: Profile) -> Profile:
    """Return a profile whose drives are slow, weak and quick to give up: nobody trusts them."""
    return _with_devices(profile, lambda its: its.gentle(SLOW, CLOSE, EFFORT))


def _with_devices(profile: Profile, change: Callable[[DriverSettings], DriverSettings]) -> Profile:
    devices = {
        name: replace(entry, settings=change(entry.settings))
        for name, entry in profile.devices.items()
    }
    return replace(profile, devices=devices)


class SlowMotion(Motion[object]):
    """A motion at a share of its speed.

    Parameters
    ----------
    mechanism : type
        Says what a reference is like that is passed more slowly.
    motion : Motion
        The whole.
    """

    def __init__(self, mechanism: type[AnyMechanism], motion: Motion[object]) -> None:
        self._mechanism = mechanism
        self._motion = motion
        self.waits, self.has_torque = motion.waits, motion.has_torque
        self.facts = motion.facts
        self.attach = motion.attach  # type: ignore[method-assign]

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self._motion.duration / SPEED

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The same stretches, later and longer."""
        return tuple(
            Segment(name, start / SPEED, end / SPEED) for name, start, end in self._motion.segments
        )

    def at(self, t: float) -> object:
        """Return the reference at `t`; see `Motion.at`."""
        return self._mechanism.slow_down(self._motion.at(SPEED * t), SPEED, 0.0)
