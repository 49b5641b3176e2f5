"""A chain of joints on CiA 402 drives, in cyclic synchronous position or velocity mode.

References
----------
IEC 61800-7-201 (CiA 402-2): state machine, modes csp (8) and csv (9). CiA 301: SYNC, PDOs.
"""

from math import inf
from typing import Final

from drivers.canopen.bus import CanopenBus
from drivers.servos.cia402_drive import Cia402Drive
from drivers.servos.cia402_settings import Cia402Settings
from drivers.servos.cia402_states import DriveState, Goal
from drivers.servos.commands import JointGuard
from rig.hal import Reading, Vector

_NOT_YET: Final = -inf


class Cia402Servos:
    """Joints on CiA 402 drives; satisfies `rig.hal.ServoBus`.

    The drives enable operation in the cycles after `arm`, one transition a time; until all of
    them have, and `is_enabled` says so, each holds its joint where it is and commands are not
    sent. The safe state is a quick stop: every drive slows its joint down by the profile's
    deceleration and then holds it (or, with ``after_stop: release``, lets its brake do so).
    Torque is not taken away in mid-motion, where gravity would take over. Connecting resets
    the drives, and that does take it away: support what has no brake before.

    In ``csp`` a velocity is integrated to positions here. In ``csv`` a position is followed
    by a proportional controller here, and so is the position at which the commanded velocity
    became zero: a drive that holds a velocity of zero lets its joint creep.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : Cia402Settings
        See there.
    bus : CanopenBus
        The bus of all these drives; with the period of its cycle, which the drives must know.
    serial : int, optional
        The serial number of the drive, where there is one only; else each joint has its own.

    Raises
    ------
    ValueError
        The bus has no period, or one that drives cannot be told; a serial number for several.
    """

    Settings = Cia402Settings

    def __init__(
        self, name: str, settings: Cia402Settings, bus: CanopenBus, *, serial: int | None = None
    ) -> None:
        if bus.period is None:
            raise ValueError(f"{name}: the bus {bus.name} has no period, which drives must know.")
        if serial is not None and len(settings.joints) > 1:
            raise ValueError(f"{name}: give each joint its serial number, not the device.")
        self.name = name
        self.settings = settings
        self.joint_names = tuple(settings.joints)
        self._bus = bus
        self._serial = serial
        self._period = bus.period
        self._drives = tuple(
            Cia402Drive(name, joint, drive, settings, bus, bus.period)
            for joint, drive in settings.joints.items()
        )
        self._guard = JointGuard(name, settings.joints, bus.period)
        self._sends_velocity = settings.mode == "csv"
        self._send = tuple(
            drive.command_velocity if self._sends_velocity else drive.command_position
            for drive in self._drives
        )
        self._held: list[float | None] = [None] * len(self._drives)
        self._armed = False
        self._enabled = False
        self._since = _NOT_YET

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Find, identify and configure every drive; leave them without torque.

        Raises
        ------
        ConnectionFailed
            A drive does not answer, is another device, is in a fault, or did not take a setting.
        """
        self._armed = self._enabled = False
        for drive in self._drives:
            own = drive.settings.serial
            drive.connect(self._serial if own is None else own)

    def arm(self) -> None:
        """Start the nodes and take first readings; the cycles from now on enable the drives.

        Raises
        ------
        ConnectionFailed
            A drive does not become OPERATIONAL, sends no readings, is in a fault, or its joint
            stands outside its limits.
        """
        self._enabled = False
        for drive in self._drives:
            drive.start()
        for drive in self._drives:
            drive.inputs.arm()
        bus = self._bus
        bus.synchronise()
        bus.wait_until(
            lambda: all(drive.inputs.is_current() for drive in self._drives),
            bus.settings.sdo_timeout,
        )
        for drive in self._drives:
            if not drive.inputs.is_current():
                drive.inputs.take_first()
        for drive in self._drives:
            drive.check_start()
        self._armed = True
        self.set_torque_enabled(True)

    def set_torque_enabled(self, enabled: bool) -> None:
        """Have the next cycles energise all joints, or slow them down and release them.

        Ignored unless armed.
        """
        if not self._armed:
            return
        self._enabled = False
        self._since = self._bus.clock.now()
        for drive in self._drives:
            drive.goal = Goal.ENABLED if enabled else Goal.DISABLED
            drive.step()

    def make_safe(self) -> None:
        """Stop every joint by its deceleration, and keep it stopped until armed again."""
        self._armed = self._enabled = False
        for drive in self._drives:
            drive.stop()

    def close(self) -> None:
        """Expect nothing of the drives any more; the bus stops the nodes. Idempotent."""
        self.make_safe()
        for drive in self._drives:
            drive.node.disarm()

    def reset_fault(self) -> None:
        """End the faults of all drives whose causes have gone: an operator's act, never ours.

        To be called on a device that is connected or refused to connect, not in the cycle.

        Raises
        ------
        ConnectionFailed
            A drive stays in its fault.
        """
        for drive in self._drives:
            drive.reset_fault()

    # The cycle ------------------------------------------------------------------------

    @property
    def is_enabled(self) -> bool:
        """Whether every drive has enabled operation and follows commands."""
        return self._enabled

    def positions(self) -> Reading[Vector]:
        """Return the joint positions, rad, shape (n,); as old as the oldest of them."""
        drives = self._drives
        return Reading(
            tuple([drive.position for drive in drives]), min([drive.time for drive in drives])
        )

    def velocities(self) -> Reading[Vector]:
        """Return the drives' own velocities, rad/s, shape (n,); 0 if not in `feedback`."""
        drives = self._drives
        return Reading(
            tuple([drive.velocity for drive in drives]), min([drive.time for drive in drives])
        )

    def torques(self) -> Reading[Vector]:
        """Return the drives' torques at the joints, N m, shape (n,); 0 if not in `feedback`."""
        drives = self._drives
        return Reading(
            tuple([drive.torque for drive in drives]), min([drive.time for drive in drives])
        )

    def command_positions(self, positions: Vector) -> None:
        """Take position setpoints for this cycle, rad, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is outside its limits, or too far from the one before for its greatest speed.
        """
        if not self._enabled:
            return
        before = self._guard.positions
        self._guard.check_positions(positions)
        if self._sends_velocity:
            self._follow(positions, before)
            return
        for send, position in zip(self._send, positions, strict=True):
            send(position)

    def command_velocities(self, velocities: Vector) -> None:
        """Take velocity setpoints for this cycle, rad/s, shape (n,); ignored until enabled.

        Raises
        ------
        LimitExceeded
            One is faster than its joint may be, or would leave its limits in ``csp``.
        """
        if not self._enabled:
            return
        guard, period = self._guard, self._period
        guard.check_velocities(velocities)
        if not self._sends_velocity:
            positions = tuple(
                [
                    position + velocity * period
                    for position, velocity in zip(guard.positions, velocities, strict=True)
                ]
            )
            guard.check_positions(positions)
            for send, position in zip(self._send, positions, strict=True):
                send(position)
            return
        guard.positions = tuple([drive.position for drive in self._drives])
        for k, velocity in enumerate(velocities):
            self._send[k](velocity if velocity else self._hold(k))
            if velocity:
                self._held[k] = None

    def check(self, now: float) -> None:
        """Raise if a drive is not well; else take those that are not enabled one step further.

        Raises
        ------
        DeviceFault
            A fault in a drive, an emergency, silence, a reboot, missing or malformed readings,
            a state or mode that nobody asked for, or a joint that does not follow. The message
            says joint, node, status word and error code in words.
        """
        for drive in self._drives:
            drive.check(now)
        if not self._armed:
            return
        if self._enabled:
            for drive in self._drives:
                drive.check_following(now)
            return
        for drive in self._drives:
            drive.step()
        if self._drives[0].goal is not Goal.ENABLED:
            return
        lagging = [
            drive for drive in self._drives if drive.state is not DriveState.OPERATION_ENABLED
        ]
        if not lagging:
            self._begin_following(now)
        elif now - self._since > self.settings.enable_time:
            raise lagging[0].fail_to_enable(now - self._since)

    def statistics(self) -> dict[str, float]:
        """Return counters for the run's manifest, of all drives together."""
        total: dict[str, float] = {}
        for drive in self._drives:
            for name, count in drive.inputs.statistics().items():
                total[name] = total.get(name, 0) + count
        return total

    # Inside ---------------------------------------------------------------------------

    def _begin_following(self, now: float) -> None:
        """Start from where each drive holds its joint: the first setpoint makes no bump."""
        for drive in self._drives:
            drive.begin_following(now)
        self._guard.positions = tuple([drive.watch.reference for drive in self._drives])
        self._held = [None] * len(self._drives)
        self._enabled = True

    def _follow(self, positions: Vector, before: Vector) -> None:
        """Follow positions with velocities: the setpoints' own, and the error times a gain."""
        gain, period = self.settings.position_gain, self._period
        for k, (send, drive) in enumerate(zip(self._send, self._drives, strict=True)):
            velocity = (positions[k] - before[k]) / period
            velocity += gain * (positions[k] - drive.position)
            fastest = drive.settings.max_speed
            send(min(max(velocity, -fastest), fastest))
            self._held[k] = None

    def _hold(self, k: int) -> float:
        """Return the velocity that keeps a joint where it was when it was to stand still."""
        drive = self._drives[k]
        held = self._held[k]
        if held is None:
            held = self._held[k] = drive.position
        fastest = drive.settings.max_speed
        velocity = self.settings.position_gain * (held - drive.position)
        return min(max(velocity, -fastest), fastest)
