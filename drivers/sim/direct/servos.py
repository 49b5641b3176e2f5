"""Servo joints of `--on sim`: the capability straight on a plant, without a bus.

Like the other devices of `drivers.sim.direct.regulators`, a reading is quantised and one cycle old,
and a setpoint acts in its own cycle, as a straight line to be at its end at the end of the next
one.
"""

from collections.abc import Mapping, Sequence
from math import copysign, inf

from drivers.servos.axis_guard import AxisGuard
from drivers.servos.axis_settings import AxisSettings
from drivers.servos.following_error import FollowingWatch
from drivers.sim.axis_faults import AxisFaults
from drivers.sim.servo_port import ServoPort
from rig.hal import Clock, DeviceFault, Reading, ServoBus, Vector, not_standing


class SimulatedAxis:
    """One joint of `SimulatedServos`, with its faults.

    Faults: ``silent`` (value: s), ``drive_fault`` (no torque, and a fault), ``stuck`` (does
    not follow any more), ``encoder_jump`` (value: rad, default 0.5), ``repair``.

    Parameters
    ----------
    name : str
        Device and joint.
    settings : AxisSettings
        Limits.
    plant : ServoPort
        The physics.
    channel : int
        The plant's joint.
    resolution : float
        Of its encoder, rad.
    deceleration : float
        Of its ramp to standstill, rad/s².
    window, time : float
        How far (rad) and for how long (s) it may be from its reference.
    """

    known_faults = ("silent", "drive_fault", "stuck", "encoder_jump", "repair")

    def __init__(
        self,
        name: str,
        settings: AxisSettings,
        plant: ServoPort,
        channel: int,
        *,
        resolution: float,
        deceleration: float,
        window: float,
        time: float,
    ) -> None:
        self.name = name
        self.settings = settings
        self.watch = FollowingWatch(window, time)
        self.position = self.velocity = self.torque = 0.0
        self.time = -inf
        self.speed = 0.0  # of the setpoint, rad/s
        self._plant = plant
        self._channel = channel
        self._resolution = resolution
        self._deceleration = deceleration
        self._silent_for = 0.0
        self._faulty = False
        self._stuck = False
        self._jump = 0.0
        self._held = False

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now.

        Raises
        ------
        ValueError
            The fault is not known here, or the value does not fit it.
        """
        if fault == "repair":
            self._silent_for, self._jump = 0.0, 0.0
            self._faulty = self._stuck = False
        elif fault == "silent":
            if value is not None and not value > 0.0:
                raise ValueError(f"{self.name}: silent lasts longer than {value:g} s")
            self._silent_for = inf if value is None else value
        elif fault == "drive_fault":
            self._faulty = True
            self.release()
        elif fault == "stuck":
            self._plant.command_joint(self._channel, self._true_position(), 0.0, True)
            self._stuck = True
        elif fault == "encoder_jump":
            self._jump += 0.5 if value is None else value
        else:
            known = ", ".join(self.known_faults)
            raise ValueError(f"{self.name}: no fault {fault!r}; known are {known}")

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
            after = copysign(max(abs(speed) - self._deceleration * period, 0.0), speed)
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


class SimulatedServos(ServoBus):
    """Joints of a plant; satisfies `rig.hal.ServoBus`.

    Faults are those of `SimulatedAxis`, of one joint (``q3.stuck``) or of all (``stuck``).

    Parameters
    ----------
    name : str
        The device's name in the profile.
    joints : mapping of str to AxisSettings
        In the order of the plant's channels.
    plant : ServoPort
        The physics.
    channels : sequence of int
        The plant's joints.
    clock : Clock
        The rig's.
    resolutions, decelerations : sequence of float
        Of each joint, rad and rad/s².
    windows, times : sequence of float
        How far (rad) and for how long (s) each may be from its reference.
    """

    def __init__(
        self,
        name: str,
        joints: Mapping[str, AxisSettings],
        plant: ServoPort,
        channels: Sequence[int],
        clock: Clock,
        *,
        resolutions: Sequence[float],
        decelerations: Sequence[float],
        windows: Sequence[float],
        times: Sequence[float],
    ) -> None:
        self.name = name
        self.axis_names = tuple(joints)
        self._clock = clock
        self.joints = tuple(
            SimulatedAxis(
                f"{name} joint {joint}",
                settings,
                plant,
                channel,
                resolution=resolution,
                deceleration=deceleration,
                window=window,
                time=time,
            )
            for (joint, settings), channel, resolution, deceleration, window, time in zip(
                joints.items(), channels, resolutions, decelerations, windows, times, strict=True
            )
        )
        # No bus says what the period is; how far a setpoint may go is the mechanism's business.
        self._guard = AxisGuard(name, joints, inf)
        self._faults = AxisFaults(name, dict(zip(joints, self.joints, strict=True)))
        self._armed = False
        self._enabled = False
        self._checked = -inf
        self._period = 0.0

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        return self._faults.known_faults

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now; errors as `AxisFaults.inject`."""
        self._faults.inject(fault, value)

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Take the first readings, without torque."""
        self._armed = self._enabled = False
        for joint in self.joints:
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
        for joint in self.joints:
            if enabled:
                joint.hold(now)
            else:
                joint.release()
        self._guard.positions = tuple([joint.watch.reference for joint in self.joints])

    def make_safe(self) -> None:
        """Slow every joint down, one period a call, and hold it then. Never raises."""
        self._armed = self._enabled = False
        for joint in self.joints:
            joint.stop(self._period)

    def unsafe(self, now: float) -> str:
        """Return which joints still move, as they are measured now; see `Device.unsafe`."""
        self._sample(now)
        return "; ".join([found for joint in self.joints if (found := joint.unsafe(now))])

    def close(self) -> None:
        """Release nothing: there is no bus."""
        self._armed = self._enabled = False

    # The cycle ------------------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether the joints follow commands."""
        return self._enabled

    def positions(self) -> Reading[Vector]:
        """Return the joint positions of the cycle before, rad, shape (n,)."""
        return self._reading([joint.position for joint in self.joints])

    def velocities(self) -> Reading[Vector]:
        """Return the joint velocities of the cycle before, rad/s, shape (n,)."""
        return self._reading([joint.velocity for joint in self.joints])

    def torques(self) -> Reading[Vector]:
        """Return the joint torques of the cycle before, N m, shape (n,)."""
        return self._reading([joint.torque for joint in self.joints])

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
        for joint, position in zip(self.joints, positions, strict=True):
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
        period = self._period
        self.command_positions(
            tuple(
                [
                    position + velocity * period
                    for position, velocity in zip(self._guard.positions, velocities, strict=True)
                ]
            )
        )

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
        for joint in self.joints:
            joint.check(now)
        if self._enabled:
            for joint in self.joints:
                joint.check_following(now)
        self._sample(now)

    # Inside ---------------------------------------------------------------------------

    def _reading(self, values: list[float]) -> Reading[Vector]:
        return Reading(tuple(values), min([joint.time for joint in self.joints]))

    def _sample(self, now: float) -> None:
        for joint in self.joints:
            joint.sample(now, self._period)
