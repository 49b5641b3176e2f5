"""One joint on one CiA 402 drive: its state machine, its codec and its faults."""

from math import inf
from typing import Any, Final

from drivers.can.cyclic import CyclicFrame
from drivers.canopen.bus import CanopenBus
from drivers.canopen.inputs import CyclicInputs, layout_struct
from drivers.canopen.node import CanopenNode, pdo_id
from drivers.cia402.codec import DriveCodec
from drivers.cia402.contact import contact_at
from drivers.cia402.errors import describe_error
from drivers.cia402.papers import DrivePapers
from drivers.cia402.settings import PROFILE, Cia402Settings, DriveSettings
from drivers.cia402.setup import (
    MODES,
    check_kind,
    check_scale,
    configure,
    prepare_velocity_stop,
    read_torque_unit,
    refuse_fault,
)
from drivers.cia402.states import (
    DISABLE_VOLTAGE,
    ENABLE_OPERATION,
    FAULTY,
    FOLLOWING_ERROR,
    LIMIT_ACTIVE,
    QUICK_STOP,
    DriveState,
    Goal,
    decode_state,
    describe_status,
    next_control,
)
from drivers.servos.axis_drive import AxisDrive
from drivers.servos.setpoint_echo import SetpointEcho
from rig.hal import ConnectionFailed, DeviceFault, not_standing

_DEMAND_SLACK: Final = 2.0  # counts
_SWITCHING: Final = 6  # cycles in which a drive must show another mode


class Cia402Drive(DrivePapers, AxisDrive[DriveSettings]):
    """The master's side of one drive.

    Parameters
    ----------
    device, joint : str
        Names in the profile.
    settings : DriveSettings
        Of the joint.
    shared : Cia402Settings
        Of all joints of the device.
    bus : CanopenBus
        With the period of its cycle.

    Attributes
    ----------
    state : DriveState or None
        Of the last status word.
    goal : Goal
        Where the state machine shall go, one transition a time.
    contact : DriveContact or None
        Its emergency stop.
    """

    position_source = "0x6064:00"

    def __init__(
        self,
        device: str,
        joint: str,
        settings: DriveSettings,
        shared: Cia402Settings,
        bus: CanopenBus,
        period: float,
    ) -> None:
        follows_velocity = shared.mode == "csv"
        # In csp the drive watches as well, and knows more: it speaks first.
        patience = settings.following_time * (1.0 if follows_velocity else 2.0)
        super().__init__(device, joint, settings, patience)
        self.status = self.error_code = 0
        self.state: DriveState | None = None
        self.goal = Goal.DISABLED
        self.node = CanopenNode(self.name, settings.node, bus)
        self._shared, self._joint = shared, joint
        self._period = period
        self._follows_velocity = follows_velocity
        codec = DriveCodec(settings)
        self._decode_position, self._encode_position = codec.decode_position, codec.encode_position
        self._decode_velocity, self._encode_velocity = codec.decode_velocity, codec.encode_velocity
        self._rounding = 2.0 * abs(codec.step)
        self._torque_unit = 0.0
        self._mode = MODES[shared.mode]
        self._shown_mode = 0
        self._stops_by_velocity = False
        self._switching = _SWITCHING
        self._counts: int | None = None
        self._earlier = -inf
        self._target = 0
        self._echo = SetpointEcho(period, _DEMAND_SLACK)
        if "demand" in shared.feedback:
            bus.lost_setpoints.append(self._echo.count_lost)
        order = shared.feedback
        self._velocity_at, self._torque_at, self._code_at, self._demand_at = (
            3 + order.index(what) if what in order else None
            for what in ("velocity", "torque", "error_code", "demand")
        )
        self.contact = contact_at(joint, shared.stop_contact)
        self._pack = layout_struct(shared.receive_layout).pack
        self.pdo = CyclicFrame(pdo_id(1, settings.node), self._pack(DISABLE_VOLTAGE, 0, self._mode))
        bus.add(self.pdo)
        self.inputs = CyclicInputs(
            self.name,
            settings.node,
            bus,
            shared.transmit_layouts(joint),
            self._take,
            hold_after=shared.hold_after,
            fault_after=shared.fault_after,
        )

    @property
    def resolution(self) -> float:
        """The angle of one count, rad."""
        return 1.0 / abs(self.settings.counts_per_radian)

    # Codec ----------------------------------------------------------------------------

    def _take(self, values: tuple[Any, ...], t: float) -> None:
        """Decode a sample; one whose position cannot be true is not taken, and is a fault."""
        if self.contact is not None:
            self.contact.see(values[-1], t)
        status, counts = values[0], values[1]
        if status != self.status:
            self.status = status
            self.state = decode_state(status)
        self._shown_mode = values[2]
        if self._code_at is not None:
            self.error_code = values[self._code_at]
        position = self._decode_position(counts)
        then = self.time
        if self._counts is not None:
            # A late sample and the next one come in one cycle and bear the same time.
            since = then if t > then else self._earlier
            reach = self._reach * (t - since) + self._rounding
            if not -reach <= position - self.position <= reach:
                what = f"the position jumped, or the joint was struck: {self.describe()}"
                self._latch_jump(what, position, reach)
                return
        if t > then:
            self._earlier = then
        self._counts = counts
        self.position = position
        self.time = t
        if self._velocity_at is not None:
            self.velocity = self._decode_velocity(values[self._velocity_at])
        if self._demand_at is not None:
            self._echo.hear(values[self._demand_at])
        if self._torque_at is not None:
            self.torque = values[self._torque_at] * self._torque_unit

    def command_position(self, position: float, velocity: float) -> None:
        """Send a target position (rad) with the next cycle, to an enabled drive in csp.

        The drive takes its velocity from the targets' distance.
        """
        self.watch.reference = position
        self._target = target = self._encode_position(position)
        self._echo.send(target)
        self.pdo.data = self._pack(ENABLE_OPERATION, target, self._mode)

    def command_velocity(self, velocity: float) -> None:
        """Send a target velocity (rad/s) with the next cycle, to an enabled drive in csv."""
        self.watch.drift(velocity, self.position, self._period)
        self.pdo.data = self._pack(ENABLE_OPERATION, self._encode_velocity(velocity), self._mode)

    # Life cycle -----------------------------------------------------------------------

    def connect(self, serial: int | None) -> None:
        """Find, identify and configure the drive; leave it without torque, PRE-OPERATIONAL.

        Raises
        ------
        ConnectionFailed
            It does not answer, is another device, is in a fault, has other units, or did not
            take a setting.
        """
        shared, node = self._shared, self.node
        self.goal = Goal.DISABLED
        try:
            kind = node.connect(
                profile=PROFILE, vendor=shared.vendor, product=shared.product, serial=serial
            )
        except ConnectionFailed as error:
            if error.object == "0x1001:00":
                raise refuse_fault(node, error) from error
            raise
        check_kind(node, kind, shared.mode)
        check_scale(node, self.settings)
        if "torque" in shared.feedback:
            self._torque_unit = read_torque_unit(node, self.settings)
        configure(node, self._joint, self.settings, shared, self._period)
        self._stops_by_velocity = prepare_velocity_stop(node, shared)

    def start(self) -> None:
        """Bring the node to OPERATIONAL, still without torque, and have its PDO sent.

        Raises
        ------
        ConnectionFailed
            It does not become OPERATIONAL.
        """
        self._trouble = None
        self.is_blind = self.has_jumped = False
        self._switching = _SWITCHING
        self._encoder.reset()
        self._counts = None
        self._earlier = -inf
        self.status = self.error_code = 0
        self.state = DriveState.NOT_READY
        self.goal = Goal.DISABLED
        # A drive that is not enabled takes a quick stop for "stay as you are".
        self.pdo.safe = self._pack(QUICK_STOP, 0, self._mode)
        self.pdo.data = self._pack(DISABLE_VOLTAGE, 0, self._mode)
        self.node.arm()
        self.pdo.active = True

    def check_start(self) -> None:
        """Refuse to energise a joint that is in a fault, or stands outside its limits.

        Raises
        ------
        ConnectionFailed
            One of the two. Outside its limits a drive would jump to the nearest one.
        """
        if self.state in FAULTY or self.state is None:
            raise ConnectionFailed(
                self.name,
                f"it cannot be enabled: {self.describe()}",
                node=self.node.node,
                object="0x6041:00",
            )
        if self._is_outside():
            raise ConnectionFailed(
                self.name,
                "the joint stands outside its limits; move it back before it is enabled",
                node=self.node.node,
                object=self.position_source,
                value=f"{self.position:.6g} rad",
                bound=self._range(),
            )

    @property
    def is_enabled(self) -> bool:
        """Whether the last status word says OPERATION ENABLED."""
        return self.state is DriveState.OPERATION_ENABLED

    def enable(self, enabled: bool) -> None:
        """Go towards OPERATION ENABLED, or by a ramp to SWITCH ON DISABLED."""
        self.goal = Goal.ENABLED if enabled else Goal.DISABLED
        self.step()

    def step(self) -> None:
        """Send the control word of the next transition; hold the joint where it is."""
        self._target = self._counts or 0
        target = 0 if self._follows_velocity else self._target
        self.pdo.data = self._pack(next_control(self.state, self.goal), target, self._mode)

    def begin_following(self, now: float) -> None:
        """Take the measured position for the reference, and the last hold for the target."""
        self.watch.reset(self._decode_position(self._target), now)
        self._echo.reset()

    def stop(self) -> None:
        """Stop quickly, from the next frame on. Never raises."""
        self.goal = Goal.STOPPED
        control, mode = QUICK_STOP, self._mode
        if self.is_blind or self.has_jumped:
            control, mode = self._stop_without_position()
        target = 0 if self._follows_velocity else self._target
        self.pdo.safe = self.pdo.data = self._pack(control, target, mode)

    def _stop_without_position(self) -> tuple[int, int]:
        """Return control word and mode that stop a joint whose position cannot be trusted.

        The velocity loop alone holds it: what gave the position away was that the velocity said
        otherwise, so the drive has that from elsewhere. A drive that does not switch loses its
        torque if its position loop would run away.
        """
        by_velocity, enabled = MODES["csv"], self.state is DriveState.OPERATION_ENABLED
        if self._shown_mode == by_velocity:
            return QUICK_STOP, by_velocity
        if not self._stops_by_velocity or not self._switching:
            return DISABLE_VOLTAGE if self.is_blind else QUICK_STOP, self._mode
        self._switching -= 1
        return ENABLE_OPERATION if enabled else QUICK_STOP, by_velocity

    def unsafe(self, now: float) -> str:
        """Return why the stopped joint is not known to be safe; see `rig.hal.Device.unsafe`."""
        # Without power it falls, or its brake holds it.
        speed = self.velocity if self.state is DriveState.QUICK_STOP_ACTIVE else 0.0
        moving = not_standing(self.name, now - self.time, speed, self.settings.max_speed)
        if not moving and self.state is DriveState.OPERATION_ENABLED:
            return f"{self.name}: it was told to stop, and is still OPERATION ENABLED"
        return moving

    # The cycle ------------------------------------------------------------------------

    def check(self, now: float) -> None:
        """Raise if the drive reports a fault, is silent, or does what nobody asked for.

        Raises
        ------
        DeviceFault
            The message says joint, node, status word and error code in words.
        """
        if self._trouble is not None:
            raise self._trouble
        # What it says of itself tells more than what follows from it.
        if self.state in FAULTY or self.node.emergency.active is not None:
            raise self.fault(f"the drive reports a fault: {self.describe()}")
        try:
            self.node.check(now)
            self.inputs.check(now)
        except DeviceFault as fault:
            raise DeviceFault(
                self.name,
                f"{fault.what}; before that: {self.describe()}",
                node=fault.node,
                object=fault.object,
                value=fault.value,
                bound=fault.bound,
            ) from fault

    def check_following(self, now: float) -> None:
        """Raise if an enabled drive is not enabled any more, or does not follow.

        Raises
        ------
        DeviceFault
            As `check`.
        """
        if self.state is not DriveState.OPERATION_ENABLED:
            raise self.fault(f"the drive left OPERATION ENABLED by itself: {self.describe()}")
        if self._shown_mode != self._mode:
            raise self.fault(
                f"the drive left its mode of operation, {self.describe()}",
                thing="0x6061:00",
                value=f"mode {self._shown_mode}",
                bound=f"mode {self._mode} ({self._shared.mode})",
            )
        if self.status & FOLLOWING_ERROR and not self._follows_velocity:
            raise self.fault(f"the drive reports a following error: {self.describe()}")
        missing = self._echo.missing
        if missing is not None:
            raise self.fault(
                f"setpoints do not arrive, or come late: {self.describe()}",
                thing="0x6062:00",
                value=f"{missing / self.settings.counts_per_radian:+.4g} rad behind",
            )
        self._check_motion(now)

    def fail_to_enable(self, since: float) -> DeviceFault:
        """Return the fault of a drive that has not become enabled in `since` seconds."""
        took, bound = f"{since:.3g} s", f"{self._shared.enable_time:g} s"
        what = f"the drive does not enable operation: {self.describe()}"
        return self.fault(what, value=took, bound=bound)

    def describe(self) -> str:
        """Return error code and status word in words."""
        emergency = self.node.emergency.active
        code = self.error_code or (0 if emergency is None else emergency.code)
        parts = [f"{describe_error(code)} (error code 0x{code:04X})"] if code else []
        if not parts and self.state in FAULTY:
            parts.append("error code not reported")
        parts.append(describe_status(self.status))
        if self.status & LIMIT_ACTIVE:
            parts.append("a limit inside the drive is active")
        return ", ".join(parts)

    # Inside ---------------------------------------------------------------------------

    def _say_outside(self) -> str:
        return f"{super()._say_outside()}: {self.describe()}"

    def fault(
        self,
        what: str,
        thing: str = "0x6041:00",
        value: str | None = None,
        bound: str | None = None,
    ) -> DeviceFault:
        """Return a fault of this drive that shows in an object, the status word unless said."""
        return DeviceFault(
            self.name, what, node=self.node.node, object=thing, value=value, bound=bound
        )
