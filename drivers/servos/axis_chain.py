"""Joints on drives, whatever the drives: what every chain of them does alike."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol, TypeVar

from drivers.servos.axis_drive import AxisDrive
from drivers.servos.axis_guard import AxisGuard
from drivers.servos.axis_readings import AxisReadings, joined
from drivers.servos.axis_settings import AxisSettings, FollowingAxisSettings
from drivers.servos.velocity_reference import VelocityReference
from rig.hal import Vector

Drive = TypeVar("Drive", bound=AxisDrive[FollowingAxisSettings])


class ServoChainSettings(Protocol):
    """The part of the settings of a chain that is the same for all drives."""

    @property
    def joints(self) -> Mapping[str, AxisSettings]:
        """The joints, in order."""

    @property
    def position_gain(self) -> float:
        """Velocity for an error in position where the drives follow velocities, 1/s."""

    @property
    def enable_time(self) -> float:
        """How long the drives may take to become enabled, s."""


class ServoChain(AxisReadings[Drive]):
    """The part of a servo driver that is the same for all drives.

    Drives are enabled in the cycles after arming. Until all of them are, and `is_enabled` says
    so, each holds its joint where it is and commands are not sent; then the first setpoint
    starts from there.

    Drives that follow positions get velocities integrated. Drives that follow velocities get
    positions by a proportional controller, and so the position at which the commanded velocity
    became zero: a drive that holds a velocity of zero lets its joint creep.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : ServoChainSettings
        Of the device.
    drives : sequence
        One per joint, in the same order.
    period : float
        Of the cycle, s.
    sends_velocity : bool
        The drives follow velocities.
    serial : int, optional
        The serial number of the drive, where there is one only; else each joint has its own.

    Raises
    ------
    ValueError
        A serial number for several drives.
    """

    def __init__(
        self,
        name: str,
        settings: ServoChainSettings,
        drives: Sequence[Drive],
        *,
        period: float,
        sends_velocity: bool,
        serial: int | None = None,
    ) -> None:
        joints = settings.joints
        if serial is not None and len(joints) > 1:
            raise ValueError(f"{name}: give each joint its serial number, not the device.")
        self.name = name
        self.axis_names = tuple(joints)
        self.drives = tuple(drives)
        self._serial = serial
        self._period = period
        self._sends_velocity = sends_velocity
        self._velocities = VelocityReference(
            settings.position_gain, [joint.max_speed for joint in joints.values()], period
        )
        self._enable_time = settings.enable_time
        self._guard = AxisGuard(name, joints, period)
        self._armed = False
        self._enabled = False
        self._enabling = False
        self._since: float | None = None

    # Life cycle -----------------------------------------------------------------------

    def set_torque_enabled(self, enabled: bool) -> None:
        """Have the next cycles energise all joints, or slow them down and release them.

        Ignored unless armed.
        """
        if not self._armed:
            return
        self._enabled = False
        self._enabling = enabled
        self._since = None  # the loop may start much later
        for drive in self.drives:
            drive.enable(enabled)

    def make_safe(self) -> None:
        """Slow every joint down to a standstill, and keep it there until armed again."""
        was_armed, self._armed = self._armed, False
        self._enabled = self._enabling = False
        for drive in self.drives:
            if was_armed or drive.is_enabled:
                drive.watch_stop()
            drive.stop()

    def unsafe(self, now: float) -> str:
        """Return which joints are not known to have come to a standstill; see `Device.unsafe`."""
        return "; ".join(filter(None, [drive.unsafe(now) for drive in self.drives]))

    # Its papers -----------------------------------------------------------------------

    def identity(self) -> Mapping[str, int]:
        """Ask every drive who it is; see `rig.hal.Device.identity`."""
        return joined({name: drive.identity() for name, drive in self._by_name()})

    def written(self) -> Mapping[str, float]:
        """Return what was read back from every drive; see `rig.hal.Device.written`."""
        return joined({name: drive.written for name, drive in self._by_name()})

    def follow_still(self) -> tuple[str, ...]:
        """Ask every drive whether it follows setpoints; see `rig.hal.ServoBus.follow_still`."""
        return tuple(name for name, drive in self._by_name() if drive.follows_still())

    # The cycle ------------------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether every drive is enabled and follows commands."""
        return self._enabled

    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is outside its limits, or too far from the one before for its greatest speed.
            No setpoint changes.
        """
        if not self._enabled:
            return
        guard, period = self._guard, self._period
        before = guard.positions
        guard.check_positions(positions)
        if self._sends_velocity:
            measured = tuple([drive.position for drive in self.drives])
            self._send(self._velocities.follow(positions, before, measured))
            return
        for k, drive in enumerate(self.drives):
            position = positions[k]
            drive.command_position(position, (position - before[k]) / period)

    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is faster than its joint may be, or would leave its limits where it is
            integrated. No setpoint changes.
        """
        if not self._enabled:
            return
        guard = self._guard
        guard.check_velocities(velocities)
        if self._sends_velocity:
            measured = guard.positions = tuple([drive.position for drive in self.drives])
            self._send(self._velocities.turn(velocities, measured))
            return
        positions = guard.moved(velocities, self._period)
        guard.check_positions(positions)
        for k, drive in enumerate(self.drives):
            drive.command_position(positions[k], velocities[k])

    def check(self, now: float) -> None:
        """Raise if a drive is not well; else take those that are not enabled one step further.

        Raises
        ------
        DeviceFault
            The message says joint, node and what the drive reports, in words.
        """
        for drive in self.drives:
            drive.check(now)
        if not self._armed:
            return
        if self._enabled:
            for drive in self.drives:
                drive.check_following(now)
            return
        for drive in self.drives:
            drive.step()
        if not self._enabling:
            return
        if self._since is None:
            self._since = now
        lagging = [drive for drive in self.drives if not drive.is_enabled]
        if not lagging:
            self._begin_following(now)
        elif now - self._since > self._enable_time:
            raise lagging[0].fail_to_enable(now - self._since)

    def doubt(self, now: float) -> str | None:
        """Return what the joint that is furthest beyond its following window says of itself."""
        if not self._enabled:
            return None
        worst = max(self.drives, key=lambda drive: abs(drive.watch.error) - drive.watch.window)
        return str(worst.lag()) if abs(worst.watch.error) > worst.watch.window else None

    # Inside ---------------------------------------------------------------------------

    def _by_name(self) -> Iterator[tuple[str, Drive]]:
        return zip(self.axis_names, self.drives, strict=True)

    def _begin_following(self, now: float) -> None:
        """Start from where each drive holds its joint: the first setpoint makes no bump."""
        for drive in self.drives:
            drive.begin_following(now)
        self._guard.positions = tuple([drive.watch.reference for drive in self.drives])
        self._velocities.reset()
        self._enabled = True

    def _send(self, velocities: Sequence[float]) -> None:
        for drive, velocity in zip(self.drives, velocities, strict=True):
            drive.command_velocity(velocity)
