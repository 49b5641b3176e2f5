"""An emulated servo drive after CiA 402 with one joint of the plant on its shaft.

References
----------
IEC 61800-7-201 (CiA 402-2): objects, option codes and modes csp and csv. Device type
0x0002_0192: profile 402 in the low word, type 2 "servo drive" in the high word.
"""

from fractions import Fraction
from functools import partial
from math import copysign, inf, pi, sqrt

from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.drive_objects import DriveObjects, error_register
from drivers.sim.nodes.drive_states import POWERED, DriveStateMachine, State, stop_for
from drivers.sim.nodes.faults import whole_number
from drivers.sim.nodes.motion_reference import MotionReference
from drivers.sim.servo_encoder import SERVO_PERIOD, ServoEncoder
from drivers.sim.servo_port import ServoPort

DEVICE_TYPE = 0x0002_0192
CSP, CSV = 8, 9
_FOLLOWING_ERROR = 0x8611
_HEARTBEAT_LOST = 0x8130
_OVER_CURRENT = 0x2310
# Status bits beside those of the state:
_VOLTAGE, _REMOTE, _LIMIT, _FOLLOWS, _BEHIND = 1 << 4, 1 << 9, 1 << 11, 1 << 12, 1 << 13

_HALT = 1 << 8  # of the control word
_IDLE_PERIOD = 10e-3  # how often a drive at rest looks at its following error, s
_I32 = 0x7FFF_FFFF
_RATED_TORQUE = 1.0  # of the motor, N m


class EmulatedCia402(EmulatedNode):
    """A servo drive: state machine, csp and csv, limits, following error, option codes.

    It interpolates setpoints over the period in 0x60C2 and hands the reference to the plant,
    which closes the servo loop. Faults of its own, beside those of `FaultInjection`:

    ``drive_fault`` (value: error code, default 0x2310)
        The drive detects a fault and reacts as 0x605E says.
    ``stuck``
        The motor does not get the reference any more: a following error results.
    ``encoder_jump``, ``encoder_frozen``, ``encoder_mirrored``, ``encoder_drift``, ``encoder_scale``
        The encoder of its position loop lies, see `ServoEncoder`.
    ``safe_torque_off``
        The input for it is open: no torque, SWITCH ON DISABLED, until repaired.
    ``wrong_mode`` (value: mode, default 1)
        Changes its mode of operation although nobody asked for it.

    What is not said here is a parameter of `EmulatedNode`.

    Parameters
    ----------
    port : ServoPort
        The plant.
    channel : int
        The plant's joint on its shaft.
    counts_per_turn : float
        Position units for one turn of the shaft.
    gear : float
        Turns of the shaft for one turn of the joint; negative if they turn against each other.
    zero : float
        The joint's angle where the encoder counts 0, rad.
    velocity_units, acceleration_units : float, optional
        Units for one turn per second (squared); None: position units.
    """

    def __init__(
        self,
        name: str,
        node_id: int,
        port: ServoPort,
        channel: int,
        *,
        counts_per_turn: float,
        gear: float = 1.0,
        zero: float = 0.0,
        velocity_units: float | None = None,
        acceleration_units: float | None = None,
        serial: int = 0,
    ) -> None:
        super().__init__(name, node_id, device_type=DEVICE_TYPE, product_code=402, serial=serial)
        self._port = ServoEncoder(port, lambda: self.now)
        self._channel = channel
        self._zero = zero
        self._counts_per_turn = counts_per_turn
        self._counts = counts_per_turn * gear / (2.0 * pi)  # per radian of the joint
        self._velocity_scale = (velocity_units or counts_per_turn) / counts_per_turn
        self._acceleration_scale = (acceleration_units or counts_per_turn) / counts_per_turn
        self._gear = gear
        self._motion = MotionReference()
        self._motion_due = self._node_due = -inf
        self._mode = 0
        self._stuck = self._torque_off = self._limited = False
        self._good_at = 0.0
        self._shown_status = 0
        self.machine = DriveStateMachine(
            self._slow_down, self._state_entered, lambda: not self._torque_off
        )
        turn = Fraction(counts_per_turn).limit_denominator(1000)
        self.objects = DriveObjects(
            self.dictionary,
            turn=(turn.numerator, turn.denominator),
            rated_torque=round(_RATED_TORQUE * 1e3),
            modes=(CSP, CSV),
            sample=lambda: self.sample_inputs(self.now),
            command=lambda: self.apply_outputs(self.now),
            cap=self._cap,
        )
        self.add_pdos(
            receive=((0x6040_0010,), (0x6040_0010, 0x607A_0020), (0x6040_0010, 0x60FF_0020)),
            transmit=((0x6041_0010,), (0x6041_0010, 0x6064_0020), (0x6041_0010, 0x606C_0020)),
        )
        self.add_fault("drive_fault", self._inject_fault)
        self.add_fault("stuck", lambda _: self._set_stuck(True), lambda: self._set_stuck(False))
        for lie in ServoEncoder.lies:
            self.add_fault(lie, partial(self._inject_lie, lie), self._port.repair)
        self.add_fault("safe_torque_off", lambda _: self._open_torque_off(), self._close_torque_off)
        self.add_fault("wrong_mode", self._inject_mode)
        self.power_on()

    # Time -----------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Run the drive's own loop, then what every node has to do."""
        if now >= self._motion_due:
            self.now = now
            self._serve(now)
        # The drive's loop is much faster than the node's business, and usually alone.
        if now >= self._node_due or self.due == -inf:
            super().tick(now)
        else:
            self.due = min(self._node_due, self._motion_due)

    def wake(self) -> None:
        """Have `tick` look at everything as soon as it is called."""
        super().wake()
        self._node_due = -inf

    deadline_moved = wake  # the status word may have changed, which an event tells

    def _plan(self) -> None:
        super()._plan()
        self._node_due = self.due
        self.due = min(self.due, self._motion_due)

    def _serve(self, now: float) -> None:
        """Bring reference, following error and ramps up to date; tell the plant."""
        machine, motion = self.machine, self._motion
        if machine.state is State.NOT_READY:
            machine.enter(State.DISABLED)  # transition 1: the drive has tested itself
        motion.advance(now)
        if machine.ending is not None and not motion.is_moving:
            machine.finish_ramp()
        powered = machine.state in POWERED
        if powered:
            if self._mode == CSV and self._follows_setpoints():
                self._limit_velocity(now)
            self._watch_following(now)
            self._pass_on(powered=True)
        period = SERVO_PERIOD if motion.is_moving or self._port.lying else _IDLE_PERIOD
        self._motion_due = now + period if machine.state in POWERED else inf
        self.due = min(self.due, self._motion_due)

    def _pass_on(self, *, powered: bool) -> None:
        if self._stuck and powered:
            return
        velocity = self._motion.velocity if powered else 0.0
        self._port.command_joint(self._channel, self._angle(), velocity / self._counts, powered)

    def _angle(self) -> float:
        """Return the joint's angle at which the reference is, rad."""
        return self._motion.position / self._counts + self._zero

    def _measured(self) -> float:
        """Return the position at the encoder, counts."""
        angle = self._port.joint_position(self._channel) - self._zero
        return round(angle * self._counts)

    # Setpoints ------------------------------------------------------------------------

    def apply_outputs(self, now: float) -> None:
        """Obey mode, control word and target, which an RPDO or an SDO has just written."""
        self._motion.advance(now)
        objects = self.objects
        self._take_mode(objects.mode.integer)
        self.machine.command(objects.control_word.integer)
        if self._follows_setpoints():
            if self._mode == CSP:
                self._take_position(now)
            elif self._mode == CSV:
                self._limit_velocity(now)
        elif self.machine.state is State.ENABLED and self.machine.ending is None:
            self._slow_down("halt")
        self._serve(now)

    def _take_mode(self, mode: int) -> None:
        """Change the mode; a velocity loop starts from where the motor is, whatever is shown."""
        changed, self._mode = mode != self._mode, mode
        self._port.closes_position = mode != CSV
        if changed and mode == CSV:
            self._restart_motion()

    def _restart_motion(self) -> None:
        angle = self._port.motor_position(self._channel) - self._zero
        self._motion.restart(round(angle * self._counts), self.now)

    def _follows_setpoints(self) -> bool:
        """Whether the drive is enabled, not on its way down, and not halted."""
        machine = self.machine
        if machine.state is not State.ENABLED or machine.ending is not None:
            return False
        return not self.objects.control_word.integer & _HALT

    def _take_position(self, now: float) -> None:
        objects = self.objects
        wanted = objects.target_position.integer + objects.position_offset.integer
        low, high = (limit.integer for limit in objects.position_limits)
        target: float = min(max(wanted, low), high) if low < high else wanted
        steps, exponent = (part.integer for part in objects.interpolation)
        duration = max(steps, 1) * 10.0**exponent
        here, reach = self._motion.position, self._fastest() * duration
        target = min(max(target, here - reach), here + reach)
        self._set_limited(target != wanted)
        self._motion.interpolate(target, duration, now)

    def _limit_velocity(self, now: float) -> None:
        """Follow the velocity, as far as a stop before the software limit permits."""
        objects = self.objects
        wanted = (
            objects.target_velocity.integer + objects.velocity_offset.integer
        ) / self._velocity_scale
        low, high = (limit.integer for limit in objects.position_limits)
        velocity = wanted
        if low < high and wanted:
            room = high - self._motion.position if wanted > 0.0 else self._motion.position - low
            fastest = sqrt(2.0 * self._ramp(objects.quick_stop_ramp.integer) * max(room, 0.0))
            velocity = copysign(min(abs(wanted), fastest), wanted)
        velocity = min(max(velocity, -self._fastest()), self._fastest())
        self._set_limited(velocity != wanted)
        if velocity != self._motion.velocity:
            self._motion.run(velocity, now)

    def _fastest(self) -> float:
        """Return the greatest speed of its motor, counts/s: 0x6080 is in turns per minute."""
        return self.objects.greatest_speed.integer / 60.0 * self._counts_per_turn

    def _cap(self) -> None:
        torque = 1e-3 * self.objects.torque_limit.integer * _RATED_TORQUE * abs(self._gear)
        self._port.limit_joint(self._channel, self._fastest() / abs(self._counts), torque)

    def _set_limited(self, limited: bool) -> None:
        if limited is not self._limited:
            self._limited = limited
            self.wake()  # the status word says so

    def _watch_following(self, now: float) -> None:
        objects = self.objects
        error = abs(self._motion.position - self._measured())
        window = objects.following_window.integer
        if self._mode != CSP or error <= window or window == 0xFFFF_FFFF:
            self._good_at = now
        elif now - self._good_at > objects.following_time.integer * 1e-3:
            self._detect_fault(_FOLLOWING_ERROR)

    # State machine --------------------------------------------------------------------

    def _state_entered(self, state: State) -> None:
        now = self.now
        if state is State.ENABLED or state not in POWERED:
            self._restart_motion()
            self._good_at = now
        if state not in POWERED:
            self._limited = False
            self._pass_on(powered=False)
        if state in (State.DISABLED, State.NOT_READY) and self.objects.error_code.integer:
            self.objects.error_code.value = 0
            self.emergency.clear_error("drive")
        self._motion_due = now
        self.wake()

    def _slow_down(self, reason: str) -> State | None:
        """Start the ramp that the option code for `reason` asks for; return what follows it."""
        objects = self.objects
        slow, quick = objects.slow_down_ramp.integer, objects.quick_stop_ramp.integer
        follows, ramp = stop_for(reason, objects.options[reason].integer, slow, quick)
        # Without a ramp the torque goes at once, and the motor runs out.
        self._motion.slow_down(self._ramp(ramp), self.now)
        self._motion_due = self.now
        self.wake()
        return follows

    def _ramp(self, units: int) -> float:
        """Return a deceleration in counts/s²."""
        return units / self._acceleration_scale

    def _detect_fault(self, code: int) -> None:
        if self.machine.state in (State.FAULT, State.FAULT_REACTION):
            return
        self.objects.error_code.value = code
        self.emergency.raise_error("drive", code, error_register(code))
        self.machine.fault()
        self._serve(self.now)
        self.wake()

    def leave_operational(self, now: float) -> None:
        """React to the loss of the master as 0x6007 says."""
        option = self.objects.options["abort connection"].integer
        if option == 1:
            self._detect_fault(_HEARTBEAT_LOST)
        elif option == 2:
            self.machine.disable_voltage()
        elif option == 3:
            self.machine.stop_quickly()

    def _heartbeat_lost(self, node: int) -> None:
        super()._heartbeat_lost(node)
        self.leave_operational(self.now)  # even where 0x1029 changes no state

    def restore_process(self) -> None:
        """Power-on: no torque, not ready, no mode. Contacts stay as they are."""
        self.machine.power_on()
        self._take_mode(0)
        self._limited = False
        self._motion.restart(0.0, self.now)
        self._cap()
        self._motion_due = self.now
        self._pass_on(powered=False)

    # Inputs ---------------------------------------------------------------------------

    def sample_inputs(self, now: float) -> None:
        """Measure, and compose the status word."""
        self._serve(now)
        objects, port, channel = self.objects, self._port, self._channel
        counts = self._measured()
        objects.position.value = int(min(max(counts, -_I32 - 1), _I32))
        velocity = port.joint_velocity(channel) * self._counts * self._velocity_scale
        objects.velocity.value = round(min(max(velocity, -_I32), _I32))
        share = port.joint_torque(channel) / self._gear / _RATED_TORQUE
        objects.torque.value = round(min(max(1e3 * share, -0x7FFF), 0x7FFF))
        error = round(self._motion.position - counts) if self.machine.state in POWERED else 0
        objects.following_error.value = error
        objects.demand.value = round(min(max(self._motion.position, -_I32), _I32))
        objects.mode_display.value = self._mode
        objects.status_word.value = self._status()

    def watch_inputs(self, now: float) -> None:
        """Mark the event-driven PDOs with the status word when it has changed."""
        status = self._status()
        if status == self._shown_status:
            return
        self._shown_status = status
        for pdo in self.pdos.transmit:
            if pdo.can_id and pdo.event_driven and self.objects.status_word in pdo.variables:
                pdo.note_change()

    def _status(self) -> int:
        machine = self.machine
        status = machine.state.value | _REMOTE
        if not self._torque_off:
            status |= _VOLTAGE
        if machine.state not in (State.QUICK_STOP, State.FAULT_REACTION):
            status |= 1 << 5  # no quick stop
        if self._limited:
            status |= _LIMIT
        if self._mode in (CSP, CSV) and self._follows_setpoints():
            status |= _FOLLOWS
        if self.objects.error_code.integer == _FOLLOWING_ERROR:
            status |= _BEHIND
        return status

    # Faults ---------------------------------------------------------------------------

    def _inject_fault(self, value: float | None) -> None:
        self._detect_fault(whole_number(self.name, "drive_fault", value, _OVER_CURRENT, 0xFFFF))

    def _inject_lie(self, how: str, value: float | None) -> None:
        self._port.lie(self._channel, how, value)
        self._motion_due = self.now

    def _inject_mode(self, value: float | None) -> None:
        mode = whole_number(self.name, "wrong_mode", value, 1, 10)
        self.objects.mode.value = mode
        self._take_mode(mode)

    def _set_stuck(self, stuck: bool) -> None:
        if stuck and self.machine.state in POWERED:
            self._motion.advance(self.now)
            self._port.command_joint(self._channel, self._angle(), 0.0, True)
        self._stuck = stuck

    def _open_torque_off(self) -> None:
        self._torque_off = True
        self.machine.disable_voltage()

    def _close_torque_off(self) -> None:
        self._torque_off = False
