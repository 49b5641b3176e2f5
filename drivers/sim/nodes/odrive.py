"""An emulated ODrive axis with one joint of the plant on its shaft, by CANSimple.

References
----------
ODrive Robotics, "CAN Protocol" of firmware 0.6, and its guides on the watchdog and on
discovering nodes: identifier ``node << 5 | command``, all values little-endian.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite, pi

from drivers.sim.nodes.bus_node import Send
from drivers.sim.nodes.motion_reference import MotionReference
from drivers.sim.nodes.odrive_faults import OdriveFaults
from drivers.sim.nodes.odrive_parameters import OdriveParameters
from drivers.sim.servo_encoder import ServoEncoder
from drivers.sim.servo_port import ServoPort

IDLE, CLOSED_LOOP = 1, 8
STEPS_PER_TURN = 1 << 14  # of the encoder on the board
SHIPPED_HEARTBEAT, SHIPPED_ENCODER = 0.1, 0.01  # periods of cyclic messages, s
VELOCITY_CONTROL, POSITION_CONTROL = 2, 3

WATCHDOG_EXPIRED, ESTOP = 0x0100_0000, 0x0200_0000
OVER_SPEED, INITIALISING = 0x8000, 0x1

_BROADCAST = 0x3F
_CONNECTIONS_SINCE = (0, 6, 11)
_NOBODY = 1  # a connection that no host gives: theirs are even; 0 is of firmware that knows none
_SERVO_PERIOD = 1e-3  # s
_OVER_SPEED_AT = 1.2  # times the limit, as the firmware ships
_FEEDFORWARD_STEP = 1e-3  # turn/s
_SAVE = 1  # of Reboot's actions


@dataclass(frozen=True, slots=True)
class OdriveBuild:
    """The make of an ODrive, its mounting and its setup.

    Parameters
    ----------
    gear : float
        Turns of the shaft for one turn of the joint; negative if they turn against each other.
    zero : float
        The joint's angle where the encoder reads 0, rad.
    steps_per_turn : int
        Of the encoder.
    serial : int
        48 bits.
    firmware : tuple of int
        As Get_Version reports it.
    watchdog : float
        Timeout, s; 0: not enabled.
    heartbeat, encoder_period : float
        Of the cyclic messages, s.
    endpoints : mapping of str to int
        Numbers of parameters, by path, see `OdriveParameters`.
    """

    gear: float = 1.0
    zero: float = 0.0
    steps_per_turn: int = STEPS_PER_TURN
    serial: int = 0
    firmware: tuple[int, int, int] = (0, 6, 11)
    watchdog: float = 0.0
    heartbeat: float = SHIPPED_HEARTBEAT
    encoder_period: float = SHIPPED_ENCODER
    endpoints: Mapping[str, int] = field(default_factory=dict)


AS_SHIPPED = OdriveBuild()
"""On the joint itself, as it comes from the maker."""


class EmulatedOdrive(OdriveFaults):
    """One axis of firmware 0.6: closed loop, heartbeat, watchdog, errors, cyclic estimates.

    Parameters
    ----------
    name : str
        Of the device and joint.
    node_id : int
        0 … 62.
    port : ServoPort
        The plant.
    channel : int
        The plant's joint on its shaft.
    build : OdriveBuild
        What the ODrive is, and how it is mounted and set up.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: ServoPort,
        channel: int,
        build: OdriveBuild = AS_SHIPPED,
    ) -> None:
        super().__init__()
        self.name = name
        self.node_id = node_id
        self.send: Send = lambda can_id, data: None
        self.listens_anew: Callable[[], None] = lambda: None
        self.now = 0.0
        self.due = 0.0
        self.serial = build.serial
        self.hardware, self.firmware = (4, 4, 58), build.firmware
        self.enable_watchdog = build.watchdog > 0.0
        self.watchdog_timeout = build.watchdog
        self.heartbeat_msg_rate_ms = round(build.heartbeat * 1e3)
        self.encoder_msg_rate_ms = round(build.encoder_period * 1e3)
        self.answers_version = True
        self.speed_limit, self.current_limit = inf, inf
        self.parameters = OdriveParameters(self, build.endpoints)
        self._port = ServoEncoder(port, lambda: self.now)
        self._channel = channel
        self._turns = build.gear / (2.0 * pi)  # per radian of the joint
        self._zero = build.zero
        self._steps = build.steps_per_turn
        self._motion = MotionReference()
        self._feedforward = 0.0  # turn/s
        self._connection = _NOBODY
        self.axis_state = IDLE
        self.active_errors = self.disarm_reason = 0
        self.control_mode, self.input_mode = POSITION_CONTROL, 1
        self._watchdog_due = self._motion_due = inf
        self._heartbeat_due = self._encoder_due = inf
        self._handlers: dict[int, tuple[int, Callable[[bytes], None]]] = {
            0x02: (0, lambda data: self.disarm(ESTOP)),
            0x04: (4, self._access_parameter),
            0x06: (7, self._take_address),
            0x07: (4, self._take_state),
            0x0B: (8, self._take_mode),
            0x0C: (8, self._take_position),
            0x0D: (8, self._take_velocity),
            0x0F: (8, self._take_limits),
            0x16: (0, self._take_reboot),
            0x18: (0, lambda data: self.clear_errors()),
        }
        self._answers: dict[int, Callable[[], bytes | None]] = {
            0x00: self._version,
            0x01: self._beat,
            0x03: lambda: struct.pack("<II", self.active_errors, self.disarm_reason),
            0x06: self._address,
            0x09: self._estimates,
        }
        self.save_configuration()

    # Time -----------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Do what is due at time `now`, s."""
        self.now = now
        if now < self.due:
            return
        self.expire_faults(now)
        if now >= self._watchdog_due:
            self._watchdog_due = inf
            self.disarm(WATCHDOG_EXPIRED)
        if now >= self._motion_due:
            self._drive(now)
        if now >= self._heartbeat_due:
            self._heartbeat_due = _next(self._heartbeat_due, self.heartbeat_msg_rate_ms, now)
            if "heartbeat_silent" not in self.lasting:
                self._transmit(0x01, self._beat())
        if now >= self._encoder_due:
            self._encoder_due = _next(self._encoder_due, self.encoder_msg_rate_ms, now)
            if "estimates_silent" not in self.lasting:
                self._transmit(0x09, self._estimates())
        self._plan()

    def _plan(self) -> None:
        self.due = min(
            self._watchdog_due,
            self._motion_due,
            self._heartbeat_due,
            self._encoder_due,
            self.fault_due,
        )

    def _drive(self, now: float) -> None:
        """Bring the reference up to date, and watch the speed."""
        self._motion.advance(now)
        by_velocity = self.control_mode == VELOCITY_CONTROL
        self._pass_on(self._motion.velocity if by_velocity else self._feedforward)
        self._motion_due = now + _SERVO_PERIOD if self.axis_state == CLOSED_LOOP else inf
        speed = abs(self._port.joint_velocity(self._channel) * self._turns)
        if speed > _OVER_SPEED_AT * self.speed_limit:
            self.disarm(OVER_SPEED)

    # Frames ---------------------------------------------------------------------------

    @property
    def transmit_ids(self) -> tuple[int, ...]:
        """CAN ids of the cyclic messages."""
        return (*self.alive_ids, self.node_id << 5 | 0x09)

    @property
    def receive_ids(self) -> tuple[int, ...]:
        """CAN ids of the setpoints."""
        return (self.node_id << 5 | 0x0C, self.node_id << 5 | 0x0D)

    @property
    def alive_ids(self) -> tuple[int, ...]:
        """CAN id of the heartbeat."""
        return (self.node_id << 5 | 0x01,)

    def hears(self, can_id: int) -> bool:
        """Return whether frames of this identifier do anything here now."""
        return can_id >> 5 in (self.node_id, _BROADCAST)

    def receive(
        self, can_id: int, data: bytes, now: float, *, extended: bool = False, remote: bool = False
    ) -> None:
        """Take a frame from the bus; what is not for this axis is ignored."""
        if extended or "silent" in self.lasting or not self.hears(can_id):
            return
        command = can_id & 0x1F
        if now >= self.due:
            self.tick(now)
        self.now = now
        if remote:
            answer = self._answers[command]() if command in self._answers else None
            if answer is not None:
                self._transmit(command, answer)
        elif command in self._handlers:
            size, handler = self._handlers[command]
            if len(data) >= size:
                handler(data)
        self._plan()
        if now >= self.due:
            self.tick(now)

    def _transmit(self, command: int, data: bytes) -> None:
        if "silent" not in self.lasting:
            self.send(self.node_id << 5 | command, data)

    def _version(self) -> bytes | None:
        if not self.answers_version:  # firmware 0.5 does not know the question
            return None
        return bytes((2, *self.hardware, *self.firmware, 0))

    def _address(self) -> bytes:
        connection = self._connection if self.firmware >= _CONNECTIONS_SINCE else 0
        return bytes((self.node_id,)) + self.serial.to_bytes(6, "little") + bytes((connection,))

    def _beat(self) -> bytes:
        return struct.pack("<IBBBB", self.active_errors, self.axis_state, 0, 1, 0)

    def _estimates(self) -> bytes:
        turns = round(self._shaft() * self._steps) / self._steps
        speed = self._port.joint_velocity(self._channel) * self._turns
        return struct.pack("<ff", turns, speed)

    # Commands -------------------------------------------------------------------------

    def _take_address(self, data: bytes) -> None:
        if int.from_bytes(data[1:7], "little") == self.serial and data[0] < _BROADCAST:
            self.node_id = data[0]
            self.listens_anew()
            if len(data) > 7:
                self._connection = data[7]  # which host it is that has it now

    def _take_state(self, data: bytes) -> None:
        (self.requested_state,) = struct.unpack_from("<I", data)

    @property
    def requested_state(self) -> int:
        """What it is to enter; it is 0 once that was heard."""
        return 0

    @requested_state.setter
    def requested_state(self, state: int) -> None:
        if state == IDLE:
            self._go_idle()
        elif state == CLOSED_LOOP and self.axis_state == IDLE and not self.active_errors:
            self.axis_state = CLOSED_LOOP
            self._motion.restart(self._shaft(), self.now)
            self._feedforward = 0.0
            self._pass_on(0.0)
            self._motion_due = self.now + _SERVO_PERIOD

    def _take_mode(self, data: bytes) -> None:
        self.control_mode, self.input_mode = struct.unpack("<II", data)

    def _take_limits(self, data: bytes) -> None:
        self.speed_limit, self.current_limit = struct.unpack("<ff", data)
        self._limit_speed()

    def _limit_speed(self) -> None:
        self._port.limit_joint(self._channel, self.speed_limit / abs(self._turns), inf)

    def _take_position(self, data: bytes) -> None:
        self._feed()
        position, velocity, _ = struct.unpack("<fhh", data)
        if self.axis_state != CLOSED_LOOP or self.control_mode != POSITION_CONTROL:
            return
        if not isfinite(position):  # its loop knows no such place
            return
        # The position stands until the next setpoint; its velocity is fed forward meanwhile.
        self._motion.restart(position, self.now)
        self._feedforward = self._limited(velocity * _FEEDFORWARD_STEP)
        self._pass_on(self._feedforward)

    def _take_velocity(self, data: bytes) -> None:
        self._feed()
        velocity, _ = struct.unpack("<ff", data)
        is_taken = self.axis_state == CLOSED_LOOP and self.control_mode == VELOCITY_CONTROL
        if is_taken and isfinite(velocity):
            self._motion.run(self._limited(velocity), self.now)
            self._pass_on(self._motion.velocity)

    def _limited(self, velocity: float) -> float:
        return min(max(velocity, -self.speed_limit), self.speed_limit)

    def _feed(self) -> None:
        timeout = self.watchdog_timeout
        self._watchdog_due = self.now + timeout if self.enable_watchdog else inf

    def _take_reboot(self, data: bytes) -> None:
        if data[:1] == bytes((_SAVE,)):
            self.save_configuration()
        else:
            self.reboot()

    def _access_parameter(self, data: bytes) -> None:
        if "sdo_silent" not in self.lasting:
            answer = self.parameters.take(data, self._connection)
            if answer is not None:
                self._transmit(0x05, answer)

    # States ---------------------------------------------------------------------------

    def disarm(self, error: int) -> None:
        """Go idle because of an error."""
        self.active_errors |= error
        if self.axis_state == CLOSED_LOOP:
            self.disarm_reason = error
        self._go_idle()

    def _go_idle(self) -> None:
        self.axis_state = IDLE
        self._motion_due = inf
        self._port.command_joint(self._channel, self._angle(self._shaft()), 0.0, False)

    def clear_errors(self) -> None:
        """Forget the errors; it may close its loop again."""
        self.active_errors = 0
        self._feed()

    def save_configuration(self) -> None:
        """Keep what is set for all times, and reboot, as the firmware does after it."""
        self.parameters.save()
        self.reboot()

    def reboot(self) -> None:
        """Begin as after power-on: idle, what was saved is kept, the rest is lost."""
        self.parameters.restore()
        self._connection = _NOBODY
        self.axis_state = IDLE
        self.active_errors = self.disarm_reason = 0
        self.control_mode, self.input_mode = POSITION_CONTROL, 1
        self.speed_limit, self.current_limit = 10.0, 10.0
        self.apply_settings()
        self._go_idle()

    def apply_settings(self) -> None:
        """Have what was written act from now on."""
        self._limit_speed()
        self._heartbeat_due = self.now if self.heartbeat_msg_rate_ms else inf
        self._encoder_due = self.now if self.encoder_msg_rate_ms else inf
        self._feed()
        self.due = -inf

    def _pass_on(self, velocity: float) -> None:
        if not self._stuck:
            angle = self._angle(self._motion.position)
            self._port.command_joint(self._channel, angle, velocity / self._turns, True)

    def _shaft(self) -> float:
        angle = self._port.joint_position(self._channel)
        return (angle - self._zero) * self._turns

    def _angle(self, turns: float) -> float:
        return turns / self._turns + self._zero


def _next(due: float, period_ms: int, now: float) -> float:
    """Return when a cyclic message comes next; its period does not drift."""
    if not period_ms:
        return inf
    following = due + period_ms * 1e-3
    return following if following > now else now + period_ms * 1e-3
