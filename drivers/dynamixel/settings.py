"""What a profile says of a serial bus and of the Dynamixel servos on it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, Self

from annotated_types import Ge, Gt, Interval, MinLen, Unit

from drivers.dynamixel.codec import MAX_ID
from drivers.dynamixel.registers import (
    COUNT_AT_ZERO,
    COUNTS_PER_TURN,
    GOAL_POSITION,
    GOAL_VELOCITY,
    HEALTH,
    MODELS,
    MOTION,
    Mode,
    Model,
    ModelName,
    Register,
)
from drivers.servos.axis_settings import SHORT, AxisSettings, bounds_of
from rig.hal import Address, BusSettings, DriverSettings, Endpoint
from rig.hal.driver import AxisBounds
from rig.hal.rules import Rules


@dataclass(frozen=True, slots=True)
class SerialBusSettings(BusSettings):
    """One serial adapter with a chain of servos, half duplex, 8 data bits, no parity.

    Parameters
    ----------
    port : str
        What the system calls the adapter; a name below ``/dev/serial/by-id`` stays the same
        when adapters are plugged in another order.
    baudrate : int
        Of every servo on the chain (their register 8), bit/s.
    fast_sync : bool
        Have the servos answer in one common packet (Fast Sync Read); False for firmware
        before version 45 or so, which does not know it.
    low_latency : bool
        Ask the adapter's driver to hand over bytes at once instead of every 16 ms.
    max_latency : float
        The slowest answer that is accepted while connecting, s. The answer to a cycle's
        request must be there when the next cycle starts.
    reply_timeout : float
        How long configuration waits for an answer, s.
    attempts : int
        How often configuration asks; a packet may get lost.
    turnaround : float
        What a reading costs beside its bytes, for the load: the adapter's and the servos'
        change of direction, s.
    max_load : float
        Highest share of the bus's time that the cycle may need.
    fault_after : int
        Answers of a servo missed, damaged or doubled in a row that are a fault. With 2 it is
        found within three cycles, wherever in a cycle it happens.
    max_refused : int
        Cycles in a row in which the port may refuse bytes before this is a fault.
    """

    port: Annotated[str, MinLen(1)]
    baudrate: Annotated[int, Unit("bit/s"), Interval(ge=9_600, le=4_500_000)] = 1_000_000
    fast_sync: bool = True
    low_latency: bool = True
    max_latency: Annotated[float, Unit("s"), Interval(ge=1e-4, le=0.1)] = 4e-3
    reply_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=1.0)] = 0.02
    attempts: Annotated[int, Interval(ge=1, le=10)] = 3
    turnaround: Annotated[float, Unit("s"), Interval(ge=0, le=5e-3)] = 100e-6
    max_load: Annotated[float, Unit("1"), Interval(gt=0, le=1)] = 0.7
    fault_after: Annotated[int, Interval(ge=1, le=10)] = 2
    max_refused: Annotated[int, Interval(ge=0, le=100)] = 2

    def endpoint(self) -> Endpoint:
        """Return the port."""
        return Endpoint("serial", self.port, self.baudrate)


@dataclass(frozen=True, slots=True, kw_only=True)
class DynamixelAxisSettings(AxisSettings):
    """One servo and the joint that it turns.

    What counts 0 on other drives is count 2048 here, the middle of the servo's turn: there
    the joint's angle is `offset`. Counts grow counter-clockwise, looking at the horn.

    Parameters
    ----------
    id : int
        The servo's, 0 … 252.
    model : str, optional
        If it is another than the device's.
    homing_offset : int
        What its register 20 must hold, counts: somebody who set another has moved the zero.
    """

    id: Annotated[int, Interval(ge=0, le=MAX_ID)]
    model: ModelName | None = None
    homing_offset: int = 0

    @property
    def counts_per_radian(self) -> float:
        """Signed counts for one radian of the joint."""
        return self.turns_per_radian * COUNTS_PER_TURN

    def servo_range(self) -> tuple[float, float]:
        """Return the joint's limits on the servo, counts, the lower first."""
        low, high = sorted(
            COUNT_AT_ZERO + (end - self.offset) * self.counts_per_radian for end in self.limits
        )
        return low, high


@dataclass(frozen=True, slots=True)
class DynamixelGains:
    """Gains of the servo's own controllers, as its registers count them.

    What is None is left as the servo has it, which after power-on is the maker's default.

    Parameters
    ----------
    position_p, position_i, position_d : int, optional
        Registers 84, 82, 80.
    velocity_p, velocity_i : int, optional
        Registers 78, 76.
    feedforward_1, feedforward_2 : int, optional
        Of the goal's velocity and acceleration: registers 90, 88.
    """

    position_p: Annotated[int, Interval(ge=0, le=16383)] | None = None
    position_i: Annotated[int, Interval(ge=0, le=16383)] | None = None
    position_d: Annotated[int, Interval(ge=0, le=16383)] | None = None
    velocity_p: Annotated[int, Interval(ge=0, le=16383)] | None = None
    velocity_i: Annotated[int, Interval(ge=0, le=16383)] | None = None
    feedforward_1: Annotated[int, Interval(ge=0, le=16383)] | None = None
    feedforward_2: Annotated[int, Interval(ge=0, le=16383)] | None = None


@dataclass(frozen=True, slots=True)
class DynamixelSettings(DriverSettings):
    """A chain of X-series servos, one per joint.

    Parameters
    ----------
    joints : dict of str to DynamixelAxisSettings
        By the joint's name, in the order of the vectors.
    model : str
        Of the servos, which must report it.
    mode : str
        ``position`` (within one turn), ``extended_position`` (many turns),
        ``current_based_position`` (with `goal_current` as a limit) or ``velocity``.
    goal_current : float, optional
        Limit of the current in ``current_based_position``, A.
    current_limit : float, optional
        Register 38, A. None: as the servo has it.
    profile_velocity : float, optional
        The greatest of the servo's own trajectory towards a setpoint, rad/s at the servo; 0:
        none. None: 15 % above the joint's `max_speed`, which setpoints that come every cycle
        never reach.
    profile_acceleration : float
        Of that trajectory, rad/s². 0: none, which is right for setpoints that come every cycle.
    gains : DynamixelGains
        Of the servo's controllers.
    watchdog : float
        After this silence the servo stops by itself, s; in steps of 20 ms. It is armed with
        the first cycle.
    position_gain : float
        In ``velocity``: velocity for an error in position, 1/s, where positions are commanded.
    after_stop : str
        What the safe state is: ``hold`` the last setpoint under torque (also after the
        program has ended), or ``release`` the torque.
    health : bool
        Read hardware error, bus watchdog, voltage and temperature of every servo in every
        cycle (15 bytes instead of 10). False for chains whose time does not allow it; a
        hardware error then shows only as such, a tripped watchdog as a joint that does not
        follow.
    echo : bool
        Read each servo's goal in every cycle, too (4 bytes more), and compare it with the
        setpoints that were sent: one that does not get them is found. Takes `health`.
    max_temperature : float
        Above it is a fault, K.
    voltage : tuple of float
        Input voltages outside are a fault, V.
    following_window, following_time : float
        A joint farther off its setpoint than this (rad) for longer than this (s) is a fault.
    """

    scaling = (
        "joints.*.gear", "joints.*.reversed", "joints.*.offset",
        "joints.*.model", "joints.*.homing_offset", "model",
    )  # fmt: skip

    joints: Annotated[dict[str, DynamixelAxisSettings], MinLen(1)]
    model: ModelName = "xm430-w350"
    mode: Mode = "position"
    goal_current: Annotated[float, Unit("A"), Gt(0)] | None = None
    current_limit: Annotated[float, Unit("A"), Gt(0)] | None = None
    profile_velocity: Annotated[float, Unit("rad/s"), Ge(0)] | None = None
    profile_acceleration: Annotated[float, Unit("rad/s^2"), Ge(0)] = 0.0
    gains: DynamixelGains = field(default_factory=DynamixelGains)
    watchdog: Annotated[float, Unit("s"), Interval(ge=0.02, le=2.54)] = 0.06
    position_gain: Annotated[float, Unit("1/s"), Gt(0)] = 10.0
    after_stop: Literal["hold", "release"] = "hold"
    health: bool = True
    echo: bool = False
    max_temperature: Annotated[float, Unit("K"), Interval(ge=293.15, le=373.15)] = 343.15
    voltage: tuple[Annotated[float, Unit("V"), Ge(0)], Annotated[float, Unit("V"), Ge(0)]] = (
        4.5,
        16.0,
    )
    following_window: Annotated[float, Unit("rad"), Gt(0)] = 0.35
    following_time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 0.5

    def __post_init__(self) -> None:
        with Rules() as rule:
            ids: dict[int, str] = {}
            for name, joint in self.joints.items():
                if joint.id in ids:
                    rule.broken(f"{ids[joint.id]} and {name} have the same id, {joint.id}.")
                ids[joint.id] = name
                rule.of(self._check_range, name, joint)
            if len({self.model_of(joint).indirect_data for joint in self.joints.values()}) > 1:
                rule.broken(
                    "the joints' models have their indirect data at different addresses, so they "
                    "cannot be read at once; put them into two devices on two buses."
                )
            if not self.voltage[0] < self.voltage[1]:
                rule.broken("voltage is not a rising pair of numbers.")
            if self.echo and not self.health:
                rule.broken("echo takes health: a goal stands apart from the motion.")
            if (self.goal_current is None) == (self.mode == "current_based_position"):
                rule.broken("goal_current belongs to mode current_based_position, which needs it.")
            for name, value in (
                ("goal_current", self.goal_current),
                ("current_limit", self.current_limit),
            ):
                if value is not None and any(
                    not self.model_of(joint).current_step for joint in self.joints.values()
                ):
                    rule.broken(f"{name}: there are servos that do not measure their current.")

    def _check_range(self, name: str, joint: DynamixelAxisSettings) -> None:
        if self.mode != "position":
            return
        low, high = joint.servo_range()
        # The full turn of the default limits ends one count beyond the last.
        if low < -1.0 or high > COUNTS_PER_TURN + 0.5:
            raise ValueError(
                f"{name}: its limits are {low:.0f} … {high:.0f} counts on servo {joint.id}, which "
                f"has 0 … {COUNTS_PER_TURN - 1} in mode position; change offset, limits or mode."
            )

    def axis_bounds(self) -> Mapping[str, AxisBounds]:
        """Return each joint's limits and greatest speed."""
        return bounds_of(self.joints)

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings for servos that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = {name: its.gentle(speed, window, effort) for name, its in self.joints.items()}
        goal = self.goal_current
        weak = None if goal is None else effort * goal
        if window >= self.following_window:
            return replace(self, joints=slow, goal_current=weak)
        short = min(self.following_time, SHORT)
        return replace(
            self, joints=slow, goal_current=weak, following_window=window, following_time=short
        )

    def channel_names(self) -> tuple[str, ...]:
        """Return the joints' names, in order."""
        return tuple(self.joints)

    def resolution(self, channel: str) -> float:
        """Return the angle of one count of a joint, rad."""
        return 1.0 / abs(self.joints[channel].counts_per_radian)

    def acts_after(self, bus: object) -> float | None:
        """Return after how long without the program it makes itself safe, s: its watchdog."""
        return self.watchdog

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return each joint's servo, which has no serial number."""
        return tuple(Address(f"{device}.{name}", its.id) for name, its in self.joints.items())

    def model_of(self, joint: DynamixelAxisSettings) -> Model:
        """Return what is known of a joint's model."""
        return MODELS[joint.model or self.model]

    @property
    def block_size(self) -> int:
        """Return the bytes that each servo sends in every cycle."""
        return sum(register.size for register in self.block)

    @property
    def block(self) -> tuple[Register, ...]:
        """Return what each servo sends in every cycle: motion, goal, health."""
        if not self.health:
            return MOTION
        return (*MOTION, *((self.goal,) if self.echo else ()), *HEALTH)

    @property
    def goal(self) -> Register:
        """Return the register that setpoints are written to."""
        return GOAL_VELOCITY if self.mode == "velocity" else GOAL_POSITION
