"""An emulated ODrive axis with one joint of the plant on its shaft, by CANSimple.

References
----------
ODrive Robotics, "CAN Protocol" of firmware 0.6, and its guides on the watchdog and on
discovering nodes: identifier ``node << 5 | command``, all values little-endian.
"""

import struct
from collections.abc import Callable
from functools import partial
from math import inf, pi

from drivers.sim.nodes.bus_node import Send
from drivers.sim.nodes.faults import FaultInjection, whole_number
from drivers.sim.nodes.motion_reference import MotionReference
from drivers.sim.servo_port import ServoPort

IDLE, CLOSED_LOOP = 1, 8
STEPS_PER_TURN = 1 << 14  # of the encoder on the board
SHIPPED_HEARTBEAT, SHIPPED_ENCODER = 0.1, 0.01  # periods of cyclic messages, s
VELOCITY_CONTROL, POSITION_CONTROL = 2, 3

OVER_VOLTAGE, WATCHDOG_EXPIRED, ESTOP = 0x100, 0x0100_0000, 0x0200_0000
OVER_SPEED, INITIALISING = 0x8000, 0x1

_BROADCAST = 0x3F
_CONNECTIONS_SINCE = (0, 6, 11)
_SERVO_PERIOD = 1e-3  # s
_OVER_SPEED_AT = 1.2  # times the limit, as the firmware ships
_FEEDFORWARD_STEP = 1e-3  # turn/s

Endpoint = tuple[str, str]


class EmulatedOdrive(FaultInjection):
    """One axis of firmware 0.6: closed loop, heartbeat, watchdog, errors, cyclic estimates.

    Faults:

    ``silent`` (value: s, default for ever)
        Off the bus: sends and hears nothing, and so its watchdog takes the torque away.
    ``heartbeat_silent``, ``estimates_silent``, ``sdo_silent`` (value: s, default for ever)
        Works, but does not send these.
    ``reboot``
        Power cycle: idle, and all that was set by CAN is lost.
    ``axis_error``, or as on other drives ``drive_fault`` (value: flags, default DC over-voltage)
        Disarms with this error.
    ``disarm``
        Goes idle although nobody asked for it.
    ``stuck``
        The motor does not follow any more.
    ``encoder_jump`` (value: rad at the joint, default 0.5)
        From now on every position is off by this much.
    ``repair``
        Ends what lasts; errors must be cleared all the same.

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
    endpoints : dict of int to (str, str)
        Numbers of parameters: the attribute here, and the `struct` code of its type.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: ServoPort,
        channel: int,
        *,
        gear: float = 1.0,
        zero: float = 0.0,
        steps_per_turn: int = STEPS_PER_TURN,
        serial: int = 0,
        firmware: tuple[int, int, int] = (0, 6, 11),
        watchdog: float = 0.0,
        heartbeat: float = SHIPPED_HEARTBEAT,
        encoder_period: float = SHIPPED_ENCODER,
        endpoints: dict[int, Endpoint] | None = None,
    ) -> None:
        super().__init__()
        self.name = name
        self.node_id = node_id
        self.send: Send = lambda can_id, data: None
        self.now = 0.0
        self.due = 0.0
        self.serial = serial
        self.firmware = firmware
        self.enable_watchdog = watchdog > 0.0
        self.watchdog_timeout = watchdog
        self.heartbeat_msg_rate_ms = round(heartbeat * 1e3)
        self.encoder_msg_rate_ms = round(encoder_period * 1e3)
        self.estimates_muted = False
        self.answers_version = True
        self.speed_limit, self.current_limit = inf, inf
        self._endpoints = endpoints or {}
        self._port = port
        self._channel = channel
        self._turns = gear / (2.0 * pi)  # per radian of the joint
        self._zero = zero
        self._steps = steps_per_turn
        self._motion = MotionReference()
        self._feedforward = 0.0  # turn/s
        self._jump = 0.0
        self._connection = 0
        self._stuck = False
        self.axis_state = IDLE
        self.active_errors = self.disarm_reason = 0
        self.control_mode, self.input_mode = POSITION_CONTROL, 1
        self._watchdog_due = self._motion_due = inf
        self._heartbeat_due = self._encoder_due = inf
        self._handlers: dict[int, tuple[int, Callable[[bytes], None]]] = {
            0x02: (0, lambda data: self.disarm(ESTOP)),
            0x04: (8, self._access_parameter),
            0x06: (7, self._take_address),
            0x07: (4, self._take_state),
            0x0B: (8, self._take_mode),
            0x0C: (8, self._take_position),
            0x0D: (8, self._take_velocity),
            0x0F: (8, self._take_limits),
            0x16: (0, lambda data: self._restart()),
            0x18: (0, lambda data: self._clear_errors()),
        }
        self._answers: dict[int, Callable[[], bytes | None]] = {
            0x00: self._version,
            0x01: self._beat,
            0x03: lambda: struct.pack("<II", self.active_errors, self.disarm_reason),
            0x06: self._address,
            0x09: self._estimates,
        }
        self._add_faults()
        self._restart()

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
            if not self.heartbeat_muted:
                self._transmit(0x01, self._beat())
        if now >= self._encoder_due:
            self._encoder_due = _next(self._encoder_due, self.encoder_msg_rate_ms, now)
            if not self.estimates_muted:
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
        return (self.node_id << 5 | 0x01, self.node_id << 5 | 0x09)

    def receive(
        self, can_id: int, data: bytes, now: float, *, extended: bool = False, remote: bool = False
    ) -> None:
        """Take a frame from the bus; what is not for this axis is ignored."""
        node, command = can_id >> 5, can_id & 0x1F
        if extended or not self.connected or node not in (self.node_id, _BROADCAST):
            return
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
        if self.connected:
            self.send(self.node_id << 5 | command, data)

    def _version(self) -> bytes | None:
        if not self.answers_version:  # firmware 0.5 does not know the question
            return None
        return bytes((2, 4, 4, 58, *self.firmware, 0))

    def _address(self) -> bytes:
        return (
            bytes((self.node_id,)) + self.serial.to_bytes(6, "little") + bytes((self._connection,))
        )

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
            if len(data) > 7 and self.firmware >= _CONNECTIONS_SINCE:
                self._connection = data[7]  # which host it is that has it now

    def _take_state(self, data: bytes) -> None:
        (state,) = struct.unpack_from("<I", data)
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

    def _take_position(self, data: bytes) -> None:
        self._feed()
        position, velocity, _ = struct.unpack("<fhh", data)
        if self.axis_state != CLOSED_LOOP or self.control_mode != POSITION_CONTROL:
            return
        # The position stands until the next setpoint; its velocity is fed forward meanwhile.
        self._motion.restart(position, self.now)
        self._feedforward = self._limited(velocity * _FEEDFORWARD_STEP)
        self._pass_on(self._feedforward)

    def _take_velocity(self, data: bytes) -> None:
        self._feed()
        velocity, _ = struct.unpack("<ff", data)
        if self.axis_state == CLOSED_LOOP and self.control_mode == VELOCITY_CONTROL:
            self._motion.run(self._limited(velocity), self.now)
            self._pass_on(self._motion.velocity)

    def _limited(self, velocity: float) -> float:
        return min(max(velocity, -self.speed_limit), self.speed_limit)

    def _feed(self) -> None:
        timeout = self.watchdog_timeout
        self._watchdog_due = self.now + timeout if self.enable_watchdog else inf

    def _clear_errors(self) -> None:
        self.active_errors = 0
        self._feed()

    def _access_parameter(self, data: bytes) -> None:
        opcode, number = data[0], int.from_bytes(data[1:3], "little")
        if number not in self._endpoints or self.sdo_muted:
            return
        attribute, code = self._endpoints[number]
        if opcode == 1:
            setattr(self, attribute, struct.unpack_from(f"<{code}", data, 4)[0])
            self._restart_timers()
        else:
            value = struct.pack(f"<{code}", getattr(self, attribute))
            self._transmit(0x05, b"\0" + data[1:3] + b"\0" + value.ljust(4, b"\0"))

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

    def _restart(self) -> None:
        """Begin as after power-on: idle, what was saved is kept, the rest is lost."""
        self.axis_state = IDLE
        self.active_errors = self.disarm_reason = 0
        self.control_mode, self.input_mode = POSITION_CONTROL, 1
        self.speed_limit, self.current_limit = 10.0, 10.0
        self._restart_timers()
        self._go_idle()

    def _restart_timers(self) -> None:
        self._heartbeat_due = self.now if self.heartbeat_msg_rate_ms else inf
        self._encoder_due = self.now if self.encoder_msg_rate_ms else inf
        self._feed()
        self._motion_due = inf
        self.due = -inf

    def _pass_on(self, velocity: float) -> None:
        if not self._stuck:
            angle = self._angle(self._motion.position)
            self._port.command_joint(self._channel, angle, velocity / self._turns, True)

    def _shaft(self) -> float:
        angle = self._port.joint_position(self._channel)
        return (angle - self._zero) * self._turns + self._jump

    def _angle(self, turns: float) -> float:
        return (turns - self._jump) / self._turns + self._zero

    # Faults ---------------------------------------------------------------------------

    def _add_faults(self) -> None:
        for fault, flag, value in (
            ("silent", "connected", False),
            ("heartbeat_silent", "heartbeat_muted", True),
            ("estimates_silent", "estimates_muted", True),
            ("sdo_silent", "sdo_muted", True),
        ):
            self.add_fault(fault, partial(self.mute, flag, value))
        self.add_fault("reboot", lambda _: self._restart())
        for fault in ("axis_error", "drive_fault"):
            self.add_fault(fault, self._inject_error)
        self.add_fault("disarm", lambda _: self._go_idle())
        self.add_fault("stuck", lambda _: self._set_stuck(True))
        self.add_fault("encoder_jump", self._inject_jump)

    def repair(self) -> None:
        """End all faults that last."""
        super().repair()
        self.estimates_muted = self._stuck = False
        self._jump = 0.0

    def _inject_error(self, value: float | None) -> None:
        self.disarm(whole_number(self.name, "axis_error", value, OVER_VOLTAGE, 0xFFFF_FFFF))

    def _inject_jump(self, value: float | None) -> None:
        self._jump += (0.5 if value is None else value) * self._turns

    def _set_stuck(self, stuck: bool) -> None:
        if stuck and self.axis_state == CLOSED_LOOP:
            angle = self._angle(self._shaft())
            self._port.command_joint(self._channel, angle, 0.0, True)
        self._stuck = stuck


def _next(due: float, period_ms: int, now: float) -> float:
    """Return when a cyclic message comes next; its period does not drift."""
    if not period_ms:
        return inf
    following = due + period_ms * 1e-3
    return following if following > now else now + period_ms * 1e-3
