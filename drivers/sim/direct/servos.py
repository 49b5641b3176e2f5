"""Servo joints of `--on sim`: the capability straight on a plant, without a bus.

Like the other devices of `drivers.sim.direct.regulators`, a reading is quantised and one cycle old,
and a setpoint acts in its own cycle, as a straight line to be at its end at the end of the next
one.
"""

from collections.abc import Mapping, Sequence
from math import copysign, inf

from drivers.servos.axis_guard import AxisGuard
from drivers.servos.axis_readings import AxisReadings
from drivers.servos.axis_settings import FollowingAxisSettings
from drivers.servos.following_error import FollowingWatch
from drivers.sim.axis_faults import AxisFaults
from drivers.sim.breakable import Breakable
from drivers.sim.servo_port import ServoPort
from rig.hal import Clock, DeviceFault, Vector, not_standing


class SimulatedAxis(Breakable):
    """One joint of `SimulatedServos`, with its faults.

    Faults: ``silent`` (value: s), ``drive_fault`` (no torque, and a fault), ``stuck`` (does
    not follow any more), ``encoder_jump`` (value: rad, default 0.5), ``repair``.

    Parameters
    ----------
    name : str
        Device and joint.
    settings : FollowingAxisSettings
        Its limits, its ramp to standstill, and how far it may be from its reference.
    plant : ServoPort
        The physics.
    channel : int
        The plant's joint.
    resolution : float
        Of its encoder, rad.
    """

    def __init__(
        self,
        name: str,
        settings: FollowingAxisSettings,
        plant: ServoPort,
        channel: int,
        resolution: float,
    ) -> None:
        super().__init__()
        self.name = name
        self.settings = settings
        self.watch = FollowingWatch(settings.following_window, settings.following_time)
        self.position = self.velocity = self.torque = 0.0
        self.time = -inf
        self.speed = 0.0  # of the setpoint, rad/s
        self._plant = plant
        self._channel = channel
        self._resolution = resolution
        self._held = False
        self.repair()
        self.add_fault("silent", self._fall_silent)
        self.add_fault("drive_fault", lambda _: self._fail())
        self.add_fault("stuck", lambda _: self._stick())
        self.add_fault("encoder_jump", self._jump_by)

    def repair(self) -> None:
        """End all faults."""
        self._silent_for, self._jump = 0.0, 0.0
        self._faulty = self._stuck = False

    def _fall_silent(self, duration: float | None) -> None:
        self._silent_for = self.lasting_time("silent", duration)

    def _fail(self) -> None:
        self._faulty = True
        self.release()

    def _stick(self) -> None:
        self._plant.command_joint(self._channel, self._true_position(), 0.0, True)
        self._stuck = True

    def _jump_by(self, angle: float | None) -> None:
        self._jump += 0.5 if angle is None else angle

    def sample(self, now: float, period: float) -> None:
        """Measure, unless the joint is silent."""
        if self._silent_for > 0.0:
            self._silent_for -= period
            return
        step = self._resolution
        self.position = round((self._true_position() + self._jump) / step) * step
        self.velocity = self._plant.joint_velocity(self._channel)
        self.torque = self._plant.joint_torque(self._channel)
        self.time = now

    def hold(self, now: float) -> None:
        """Stand still under torque where the joint is."""
        self.watch.reset(self._true_position(), now)
        self.speed = 0.0
        self._held = True
        self._command(self.watch.reference, 0.0)

    def move(self, position: float, period: float) -> None:
        """Go to a position (rad) in a straight line that takes one period."""
        before = self.watch.reference
        self.watch.reference = position
        self.speed = (position - before) / period if period > 0.0 else 0.0
        self._command(before, self.speed)

    def stop(self, period: float) -> None:
        """Move one period further along the ramp to standstill, and stay there then."""
        if not self._held:
            return
        speed = self.speed
        if speed and period > 0.0:
            after = copysign(max(abs(speed) - self.settings.deceleration * period, 0.0), speed)
            self.move(self.watch.reference + 0.5 * (speed + after) * period, period)
            self.speed = after
        else:
            self.speed = 0.0
            self._command(self.watch.reference, 0.0)

    def unsafe(self, now: float) -> str:
        """Return why the joint is not known to stand still, if it is held; see `Device.unsafe`."""
        speed = self.velocity if self._held else 0.0
        return not_standing(self.name, now - self.time, speed, self.settings.max_speed)

    def release(self) -> None:
        """Take the torque away."""
        self._held = False
        self._plant.command_joint(self._channel, self._true_position(), 0.0, False)

    def check(self, now: float) -> None:
        """Raise if the joint reports a fault.

        Raises
        ------
        DeviceFault
            The message names device and joint.
        """
        if self._faulty:
            raise DeviceFault(self.name, "the drive reports a fault: simulated")

    def check_following(self, now: float) -> None:
        """Raise if the joint does not follow.

        Raises
        ------
        DeviceFault
            The message names device and joint.
        """
        duration = self.watch.exceeds(self.position, now)
        if duration:
            raise DeviceFault(
                self.name,
                "the joint does not follow its reference",
                value=f"{self.watch.error:+.4g} rad for {duration:.3g} s",
                bound=f"{self.watch.window:g} rad for {self.watch.time:g} s",
            )

    def _true_position(self) -> float:
        return self._plant.joint_position(self._channel)

    def _command(self, position: float, velocity: float) -> None:
        if not (self._faulty or self._stuck):
            self._plant.command_joint(self._channel, position, velocity, True)


class SimulatedServos(AxisFaults, AxisReadings[SimulatedAxis]):
    """Joints of a plant; satisfies `rig.hal.ServoBus`.

    Faults are those of `SimulatedAxis`, of one joint (``q3.stuck``) or of all (``stuck``).

    Parameters
    ----------
    name : str
        The device's name in the profile.
    joints : mapping of str to FollowingAxisSettings
        In the order of the plant's channels.
    plant : ServoPort
        The physics.
    channels : sequence of int
        The plant's joints.
    clock : Clock
        The rig's.
    resolutions : sequence of float
        Of each joint's encoder, rad.
    """

    def __init__(
        self,
        name: str,
        joints: Mapping[str, FollowingAxisSettings],
        plant: ServoPort,
        channels: Sequence[int],
        clock: Clock,
        resolutions: Sequence[float],
    ) -> None:
        self.axis_names = tuple(joints)
        self._clock = clock
        self.drives = tuple(
            SimulatedAxis(f"{name} joint {joint}", settings, plant, channel, resolution)
            for (joint, settings), channel, resolution in zip(
                joints.items(), channels, resolutions, strict=True
            )
        )
        super().__init__(name, dict(zip(joints, self.drives, strict=True)))
        # No bus says what the period is; how far a setpoint may go is the mechanism's business.
        self._guard = AxisGuard(name, joints, inf)
        self._armed = False
        self._enabled = False
        self._checked = -inf
        self._period = 0.0

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Take the first readings, without torque."""
        self._armed = self._enabled = False
        for joint in self.drives:
            joint.release()
        self._sample(self._clock.now())

    def arm(self) -> None:
        """Hold every joint where it is, and follow setpoints from now on."""
        self._armed = True
        self.set_torque_enabled(True)
        self._sample(self._clock.now())

    def listen(self) -> None:
        """Take readings from now on, without torque."""
        self._armed = True
        self._sample(self._clock.now())

    def set_torque_enabled(self, enabled: bool) -> None:
        """Hold every joint where it is, or let go of them; ignored unless armed."""
        if not self._armed:
            return
        now = self._clock.now()
        self._enabled = enabled
        for joint in self.drives:
            if enabled:
                joint.hold(now)
            else:
                joint.release()
        self._guard.positions = tuple([joint.watch.reference for joint in self.drives])

    def make_safe(self) -> None:
        """Slow every joint down, one period a call, and hold it then. Never raises."""
        self._armed = self._enabled = False
        for joint in self.drives:
            joint.stop(self._period)

    def unsafe(self, now: float) -> str:
        """Return which joints still move, as they are measured now; see `Device.unsafe`."""
        self._sample(now)
        return "; ".join([found for joint in self.drives if (found := joint.unsafe(now))])

    def close(self) -> None:
        """Release nothing: there is no bus."""
        self._armed = self._enabled = False

    # The cycle ------------------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether the joints follow commands."""
        return self._enabled

    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is outside its limits.
        """
        if not self._enabled:
            return
        self._guard.check_positions(positions)
        for joint, position in zip(self.drives, positions, strict=True):
            joint.move(position, self._period)

    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is faster than its joint may be, or would leave its limits.
        """
        if not self._enabled:
            return
        self._guard.check_velocities(velocities)
        self.command_positions(self._guard.moved(velocities, self._period))

    def check(self, now: float) -> None:
        """Raise if a joint is not well, then sample the next readings.

        Raises
        ------
        DeviceFault
            A joint reports a fault, or does not follow.
        """
        if self._checked > -inf:
            self._period = now - self._checked
        self._checked = now
        for joint in self.drives:
            joint.check(now)
        if self._enabled:
            for joint in self.drives:
                joint.check_following(now)
        self._sample(now)

    # Inside ---------------------------------------------------------------------------

    def _sample(self, now: float) -> None:
        for joint in self.drives:
            joint.sample(now, self._period)
