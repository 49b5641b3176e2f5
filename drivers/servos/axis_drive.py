"""One joint's drive, whatever the drive: what every driver of drives does alike."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import inf
from typing import ClassVar, Final, Generic, TypeVar

from drivers.servos.axis_settings import FollowingAxisSettings
from drivers.servos.encoder_watch import EncoderWatch
from drivers.servos.following_error import FollowingWatch
from rig.hal import DeviceFault, not_standing

_JUMP: Final = 1.5  # readings that imply so many times the greatest speed are no motion

Axis = TypeVar("Axis", bound=FollowingAxisSettings, covariant=True)


class AxisDrive(ABC, Generic[Axis]):
    """The master's side of one joint's drive.

    Parameters
    ----------
    device, joint : str
        Names in the profile.
    settings : FollowingAxisSettings
        Of the joint.
    patience : float
        For how long the joint may be away from its reference, s.

    Attributes
    ----------
    position, velocity, torque : float
        Of the joint, rad, rad/s, N m; 0 where the drive does not tell.
    time : float
        When they were sampled, s.
    watch : FollowingWatch
        Where the joint should be.
    is_blind : bool
        Its encoder was found to lie: its position loop cannot hold the joint.
    has_jumped : bool
        Its position is off by what it jumped, and its loop moves the joint by as much.
    """

    position_source: ClassVar[str]
    """What bears the position on the wire."""

    def __init__(self, device: str, joint: str, settings: Axis, patience: float) -> None:
        self.name = f"{device} joint {joint}"
        self.settings: Axis = settings
        self.position = self.velocity = self.torque = 0.0
        self.time = -inf
        self.watch = FollowingWatch(settings.following_window, patience)
        self._reach = _JUMP * settings.max_speed
        self._trouble: DeviceFault | None = None
        self.is_blind = self.has_jumped = False
        self._encoder = EncoderWatch(self.resolution)

    @property
    @abstractmethod
    def resolution(self) -> float:
        """The least difference of positions, rad."""

    # The chain's orders ---------------------------------------------------------------

    @property
    @abstractmethod
    def is_enabled(self) -> bool:
        """Whether it says that it follows its setpoints."""

    @abstractmethod
    def enable(self, enabled: bool) -> None:
        """Begin to energise the joint, or to slow it down and release it."""

    @abstractmethod
    def step(self) -> None:
        """Take one step of that, while the joint is held or free; called once a cycle."""

    @abstractmethod
    def begin_following(self, now: float) -> None:
        """Take the setpoint that holds the joint for the first reference."""

    @abstractmethod
    def command_position(self, position: float, velocity: float) -> None:
        """Take a position setpoint (rad) that moves at a velocity (rad/s)."""

    @abstractmethod
    def command_velocity(self, velocity: float) -> None:
        """Take a velocity setpoint, rad/s."""

    @abstractmethod
    def stop(self) -> None:
        """Slow the joint down to a standstill. Never raises."""

    def watch_stop(self) -> None:
        """Note whether the encoder of a joint that is stopped lies: it stops otherwise then."""
        if self._encoder.look(self.time, self.position, self.velocity) is not None:
            self.is_blind = True

    def unsafe(self, now: float) -> str:
        """Return why the stopped joint is not known to be safe; see `rig.hal.Device.unsafe`.

        Default: an enabled drive holds its joint, which must stand still.
        """
        speed = self.velocity if self.is_enabled else 0.0
        return not_standing(self.name, now - self.time, speed, self.settings.max_speed)

    # Its papers -----------------------------------------------------------------------

    @abstractmethod
    def identity(self) -> Mapping[str, int]:
        """Ask who it is; see `rig.hal.Device.identity`."""

    @property
    @abstractmethod
    def written(self) -> Mapping[str, float]:
        """What was written and read back; see `rig.hal.Device.written`."""

    @abstractmethod
    def follows_still(self) -> bool:
        """Ask whether it follows setpoints, without the cycle."""

    # Its faults -----------------------------------------------------------------------

    @abstractmethod
    def check(self, now: float) -> None:
        """Raise `DeviceFault` if the drive is not well; the message says why in words."""

    @abstractmethod
    def check_following(self, now: float) -> None:
        """Raise `DeviceFault` if the enabled drive does not do what it was told."""

    @abstractmethod
    def fail_to_enable(self, since: float) -> DeviceFault:
        """Return the fault of a drive that has not become enabled in so many seconds."""

    @abstractmethod
    def describe(self) -> str:
        """Return what the drive says of itself in words."""

    @abstractmethod
    def fault(
        self, what: str, thing: str, value: str | None = None, bound: str | None = None
    ) -> DeviceFault:
        """Return a fault of this drive that shows in `thing`, an object or a frame."""

    def lag(self) -> DeviceFault:
        """Return what would be the fault if the joint went on to be away from its reference."""
        return self.fault(
            f"the joint is not where its reference is: {self.describe()}",
            self.position_source,
            f"{self.watch.error:+.4g} rad",
            f"{self.watch.window:g} rad",
        )

    def _is_outside(self, margin: float = 0.0) -> bool:
        low, high = self.settings.limits
        return not low - margin <= self.position <= high + margin

    def _range(self) -> str:
        low, high = self.settings.limits
        return f"{low:g} … {high:g} rad"

    def _say_outside(self) -> str:
        return "the joint left its limits"

    def _check_motion(self, now: float) -> None:
        """Raise if the joint is outside its limits, or away from its reference."""
        if self._is_outside(self.settings.following_window):
            raise self.fault(
                self._say_outside(),
                self.position_source,
                f"{self.position:.6g} rad",
                self._range(),
            )
        lie = self._encoder.look(self.time, self.position, self.velocity)
        if lie is not None:
            self.is_blind = True
            raise self.fault(f"{lie}; {self.describe()}", self.position_source)
        duration = self.watch.exceeds(self.position, now)
        if duration:
            raise self.fault(
                f"the joint does not follow its reference: {self.describe()}",
                self.position_source,
                f"{self.watch.error:+.4g} rad for {duration:.3g} s",
                f"{self.watch.window:g} rad for {self.watch.time:g} s",
            )

    def _latch_jump(self, what: str, position: float, reach: float) -> None:
        """Keep the fault of a position that is further away than the joint can have moved."""
        self.has_jumped = True
        if self._trouble is None:
            self._trouble = self.fault(
                what,
                self.position_source,
                f"{position - self.position:+.6g} rad",
                f"{reach:.3g} rad",
            )
