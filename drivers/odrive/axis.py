"""One joint on one ODrive axis: its setpoints, its readings and its faults."""

from contextlib import suppress
from math import copysign, inf, isfinite
from typing import Final

from drivers.can.cyclic import CyclicFrame
from drivers.odrive.bus import OdriveBus
from drivers.odrive.client import OdriveClient
from drivers.odrive.codec import (
    FEEDFORWARD_RANGE,
    PASSTHROUGH,
    WATCHDOG_TIMER_EXPIRED,
    AxisState,
    Command,
    ControlMode,
    can_id,
    decode_estimates,
    describe_errors,
    encode_axis_state,
    encode_controller_mode,
    encode_input_position,
    encode_input_velocity,
    encode_limits,
)
from drivers.odrive.papers import AxisPapers
from drivers.odrive.read_back import ReadBack, armed_settings
from drivers.odrive.settings import OdriveAxisSettings, OdriveSettings
from drivers.servos.axis_drive import AxisDrive
from rig.hal import ConnectionFailed, DeviceFault

_COUNTED: Final = 8  # estimates over which their rate is measured
_SLOWEST: Final = 1.5  # times the period that the profile says
_FINEST: Final = 1.0 / (1 << 14)  # turn, of the encoder on the board
_STILL: Final = 0.01  # of the greatest speed
_REQUESTS: Final = 4  # of a state, before it is a fault
_ANSWERS_IN: Final = 2.0  # heartbeats; what the first one says may be older than the request


class OdriveAxis(AxisPapers, AxisDrive[OdriveAxisSettings]):
    """The master's side of one axis.

    Parameters
    ----------
    device, joint : str
        Names in the profile.
    settings : OdriveAxisSettings
        Of the joint.
    shared : OdriveSettings
        Of all joints of the device.
    bus : OdriveBus
        The bus.
    period : float
        Of the cycle, s.

    Attributes
    ----------
    time : float
        When the readings were sent at the earliest, s.
    """

    position_source = "Get_Encoder_Estimates"

    def __init__(
        self,
        device: str,
        joint: str,
        settings: OdriveAxisSettings,
        shared: OdriveSettings,
        bus: OdriveBus,
        period: float,
    ) -> None:
        super().__init__(device, joint, settings, settings.following_time)
        self.client = OdriveClient(self.name, settings.axis, bus)
        self._shared = shared
        self._bus = bus
        self._period = period
        self._gain = settings.turns_per_radian
        self._radians = 1.0 / settings.turns_per_radian
        self._steps = shared.feedforward_scale * self._gain if shared.feedforward else 0.0
        self._follows_velocity = shared.mode == "velocity"
        self.samples = 0
        self._has_position = False
        self._wanted = False
        self._follows = False
        self._read_back = ReadBack(
            self.client, armed_settings(shared, settings), bus.settings.reply_timeout
        )
        self._asks_again = -inf
        self._speed = 0.0  # of the setpoint, rad/s
        command = Command.SET_INPUT_VEL if self._follows_velocity else Command.SET_INPUT_POS
        self.setpoint = CyclicFrame(can_id(settings.axis, command), bytes(8))
        bus.add(self.setpoint)
        bus.subscribe(can_id(settings.axis, Command.GET_ENCODER_ESTIMATES), self._take)

    @property
    def resolution(self) -> float:
        """The angle of one step of the encoder on the board, rad."""
        return _FINEST / abs(self.settings.turns_per_radian)

    # Codec ----------------------------------------------------------------------------

    def _take(self, data: bytes, now: float) -> None:
        """Decode an estimate; one that cannot be true is not taken, and is a fault."""
        if len(data) != 8:
            return
        turns, speed = decode_estimates(data)
        position = turns * self._radians + self.settings.offset
        # They come once a period, so that what has just come is no older than that.
        t = max(self._bus.received_before, now - self._shared.encoder_period)
        if self._has_position:
            # It was sampled anywhere between two receptions, and so was the one before.
            reach = self._reach * (now - self.time) + 2e-3
            if not -reach <= position - self.position <= reach:
                what = f"the position jumped, or the joint was struck: {self.describe()}"
                self._latch_jump(what, position, reach)
                return
        elif not isfinite(position):
            return
        self._has_position = True
        self.samples += 1
        self.position = position
        self.velocity = speed * self._radians
        self.time = t if t > self.time else self.time

    def command_position(self, position: float, velocity: float) -> None:
        """Send a position (rad) and its velocity (rad/s) from the next cycle on."""
        self.watch.reference = position
        self._speed = velocity
        steps = round(velocity * self._steps)
        self.setpoint.data = encode_input_position(
            (position - self.settings.offset) * self._gain,
            min(max(steps, -FEEDFORWARD_RANGE), FEEDFORWARD_RANGE),
        )

    def command_velocity(self, velocity: float) -> None:
        """Send a velocity (rad/s) from the next cycle on."""
        self.watch.drift(velocity, self.position, self._period)
        self._speed = velocity
        self.setpoint.data = encode_input_velocity(velocity * self._gain, 0.0)

    # Life cycle -----------------------------------------------------------------------

    def connect(self) -> None:
        """Identify and configure the axis, whose heartbeat has come; leave it idle.

        Raises
        ------
        ConnectionFailed
            It is another one, has the wrong firmware, reports errors, or does not send what
            the profile says.
        """
        client, shared = self.client, self._shared
        self._wanted = self.setpoint.active = False
        client.read_version()
        client.compare_serial(self.settings.serial)
        self._refuse_errors()
        client.enter(AxisState.IDLE)
        self._write_parameters()
        self._send_limits()
        self._measure_rate(shared.encoder_period)

    def check_start(self) -> None:
        """Refuse to energise a joint whose reading is old, or that stands outside its limits.

        Raises
        ------
        ConnectionFailed
            One of the two.
        """
        self._trouble = None
        self.is_blind = False
        self._encoder.reset()
        self._has_position = False
        before = self.samples
        if not self._bus.wait_until(
            lambda: self.samples > before, self._bus.settings.reply_timeout
        ):
            raise self.client.failed("no encoder estimates come", object="Get_Encoder_Estimates")
        if self._is_outside():
            raise self.client.failed(
                "the joint stands outside its limits; move it back before it is enabled",
                object=self.position_source,
                value=f"{self.position:.6g} rad",
                bound=self._range(),
            )

    def enable(self, enabled: bool) -> None:
        """Hold the joint where it is and close the loop, or slow it down and open it."""
        self._wanted = enabled
        self._follows = False
        self._asks_again = -inf
        if enabled:
            self._read_back.restart()
            self._hold_here()
            self.setpoint.active = True

    def step(self) -> None:
        """Ask for the state that is wanted; its setpoints have fed the watchdog before.

        A request is repeated after a while, should it have been lost. The error of a watchdog
        that expired before anything fed it, as after every run, is cleared first.
        """
        now = self._bus.clock.now()
        if not self._wanted and self._speed:
            self.stop()
            return
        client = self.client
        state = AxisState.CLOSED_LOOP_CONTROL if self._wanted else AxisState.IDLE
        if client.state == state:
            if self._wanted:
                self._compare_settings(now)
            return
        if now < self._asks_again:
            return
        if client.errors == WATCHDOG_TIMER_EXPIRED:
            self._asks_again = now + _ANSWERS_IN * self._shared.heartbeat
            client.send(Command.CLEAR_ERRORS, bytes(1))
            return
        self._asks_again = now + self._shared.enable_time / _REQUESTS
        self._hold_here()
        if self._wanted:  # it may have rebooted since it was configured
            self._send_limits()
        client.send(Command.SET_AXIS_STATE, encode_axis_state(state))

    @property
    def is_enabled(self) -> bool:
        """Whether a heartbeat has confirmed the closed loop, and its settings were read back."""
        closed = self.client.state == AxisState.CLOSED_LOOP_CONTROL
        return self._wanted and closed and self._read_back.is_done

    def begin_following(self, now: float) -> None:
        """Take the position that is held for the reference."""
        self._follows = True
        self.watch.reset(self.watch.reference, now)

    @property
    def is_still(self) -> bool:
        """Whether setpoint and joint stand still, or nobody listens to the setpoint."""
        if self.client.state != AxisState.CLOSED_LOOP_CONTROL:
            return True
        return not self._speed and abs(self.velocity) <= _STILL * self.settings.max_speed

    def stop(self) -> None:
        """Move the setpoint one period further along a ramp to standstill. Never raises."""
        if self.is_blind:  # its loop would run away
            self.release()
            return
        speed = self._speed
        if not speed:
            return
        after = max(abs(speed) - self.settings.deceleration * self._period, 0.0)
        after = copysign(after, speed) if after else 0.0
        if self._follows_velocity:
            self.command_velocity(after)
            return
        low, high = self.settings.limits
        target = self.watch.reference + 0.5 * (speed + after) * self._period
        self.command_position(min(max(target, low), high), after)

    def release(self) -> None:
        """Take the torque away, and expect nothing any more. Never raises."""
        if not self.setpoint.active:
            return
        self.setpoint.active = self._wanted = False
        with suppress(ConnectionFailed):  # the watchdog does it
            self.client.send(Command.SET_AXIS_STATE, encode_axis_state(AxisState.IDLE))

    # The cycle ------------------------------------------------------------------------

    def check(self, now: float) -> None:
        """Raise if the armed axis reports an error or is silent.

        Raises
        ------
        DeviceFault
            The message says joint, node, errors and state in words.
        """
        if not self.setpoint.active:
            return
        if self._trouble is not None:
            raise self._trouble
        client, shared = self.client, self._shared
        # What it says of itself tells more than what follows from it.
        if client.errors and (self._follows or client.errors != WATCHDOG_TIMER_EXPIRED):
            raise self.fault(f"the axis reports an error: {client.describe()}", "Heartbeat")
        if now - client.heard > (bound := self._patience(shared.heartbeat)):
            raise self.fault(
                f"the axis's heartbeat is lost; before that: {client.describe()}",
                "Heartbeat",
                f"{now - client.heard:.3f} s of silence",
                f"{bound:g} s",
            )
        if now - self.time > (bound := self._patience(shared.encoder_period)):
            raise self.fault(
                f"the axis sends no encoder estimates any more: {client.describe()}",
                "Get_Encoder_Estimates",
                f"{now - self.time:.3f} s of silence",
                f"{bound:g} s",
            )

    def check_following(self, now: float) -> None:
        """Raise if an enabled axis opened its loop, or does not follow.

        Raises
        ------
        DeviceFault
            As `check`.
        """
        if self.client.state != AxisState.CLOSED_LOOP_CONTROL:
            raise self.fault(
                f"the axis left its closed loop by itself: {self.describe()}", "Heartbeat"
            )
        self._check_motion(now)

    def fail_to_enable(self, since: float) -> DeviceFault:
        """Return the fault of an axis that has not closed its loop in `since` seconds."""
        return self.fault(
            f"the axis does not close its loop: {self.describe()}",
            "Set_Axis_State",
            f"{since:.3g} s",
            f"{self._shared.enable_time:g} s",
        )

    # Inside ---------------------------------------------------------------------------

    def _hold_here(self) -> None:
        if self._follows_velocity:
            self.watch.reference = self.position
            self.command_velocity(0.0)
        else:
            self.command_position(self.position, 0.0)

    def _refuse_errors(self) -> None:
        """Refuse an axis in an error; an expired watchdog is how every run may end."""
        active, reason = self.client.read_errors()
        if active & ~WATCHDOG_TIMER_EXPIRED:
            raise self.client.failed(
                f"it reports an error before it is used: {describe_errors(active)}; it was "
                f"disarmed by: {describe_errors(reason)}; remove the cause and clear it",
                object="Get_Error",
                value=f"0x{active:08X}",
            )

    def _write_parameters(self) -> None:
        numbers, shared, client = self._shared.endpoints, self._shared, self.client
        if numbers is None:
            return
        client.write_parameter(numbers.watchdog_timeout, "watchdog_timeout", shared.watchdog, "f")
        client.write_parameter(numbers.enable_watchdog, "enable_watchdog", True, "?")
        for number, what, period in (
            (numbers.heartbeat_period, "heartbeat_msg_rate_ms", shared.heartbeat),
            (numbers.encoder_period, "encoder_msg_rate_ms", shared.encoder_period),
        ):
            if number is not None:
                client.write_parameter(number, what, round(period * 1e3), "I")

    def _send_limits(self) -> None:
        client, settings = self.client, self.settings
        mode = ControlMode.VELOCITY if self._follows_velocity else ControlMode.POSITION
        client.send(Command.SET_CONTROLLER_MODE, encode_controller_mode(mode, PASSTHROUGH))
        limits = encode_limits(settings.motor_speed_limit, settings.current_limit)
        client.send(Command.SET_LIMITS, limits)

    def _compare_settings(self, now: float) -> None:
        """Take one step of reading the armed axis back; another value is a fault."""
        lost = self._read_back.step(now)
        if lost is not None and self._trouble is None:
            self._trouble = self.fault(
                "the axis has lost its settings; it rebooted after it was configured", *lost
            )

    def _measure_rate(self, period: float) -> None:
        """Refuse an axis that sends its estimates much more seldom than the profile says."""
        bus, samples = self._bus, self.samples
        allowed = _SLOWEST * _COUNTED * period
        if not bus.wait_until(lambda: self.samples >= samples + _COUNTED, allowed):
            raise self.client.failed(
                "its encoder estimates come too seldom; set encoder_msg_rate_ms",
                object="Get_Encoder_Estimates",
                value=f"{self.samples - samples} in {allowed:g} s",
                bound=f"one in {period:g} s",
            )

    def _patience(self, period: float) -> float:
        return self._shared.fault_after * max(period, self._period)

    def describe(self) -> str:
        """Return the axis's errors and state in words."""
        return self.client.describe()

    def fault(
        self, what: str, thing: str, value: str | None = None, bound: str | None = None
    ) -> DeviceFault:
        """Return a fault of this axis that shows in a frame."""
        return DeviceFault(
            self.name, what, node=self.settings.axis, object=thing, value=value, bound=bound
        )
