"""Joints on servo drives: what an arm and a pair of legs have in common."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, NamedTuple, Protocol, TypeVar

from controllers.minimum_jerk import minimum_jerk
from rig.hal import (
    Device,
    EmergencyStopInput,
    LimitExceeded,
    SafetyError,
    ServoBus,
    StaleReading,
    Vector,
)
from rig.hal.mechanism import Mechanism, Settings
from rig.hal.picking import DevicePicker
from rig.hal.quantities import Margin
from rig.mechanisms.servo.asked import AskedPositions
from rig.mechanisms.servo.columns import servo_columns as servo_columns  # noqa: PLC0414 - others
from rig.mechanisms.servo.settings import ServoLimits, ServoSettings
from rig.mechanisms.servo.stuck import StandstillWatch
from rig.mechanisms.servo.wiring import wire_axes
from rig.mechanisms.stop_contact import StopContact


class AxisLimits(NamedTuple):
    """The joints of a mechanism and what they may do.

    Parameters
    ----------
    names : tuple of str
        In the order of every vector.
    lower, upper : tuple of float
        Permitted positions, rad.
    rates : tuple of float
        Greatest speeds, rad/s.
    """

    names: tuple[str, ...]
    lower: Vector
    upper: Vector
    rates: Vector


class AxisValues(Protocol):
    """The common part of state, reference and command of a mechanism on servo axes."""

    @property
    def positions(self) -> Vector: ...  # noqa: D102 - rad
    @property
    def velocities(self) -> Vector: ...  # noqa: D102 - rad/s


State = TypeVar("State", bound=AxisValues)
Reference = TypeVar("Reference", bound=AxisValues)
Command = TypeVar("Command", bound=AxisValues)


class Kinds(NamedTuple, Generic[State, Reference, Command]):
    """The types that a mechanism's controllers speak.

    Parameters
    ----------
    state : callable
        ``state(t, positions, velocities)``.
    reference : callable
        ``reference(positions, velocities, follow)``.
    command : callable
        ``command(positions, velocities)``.
    """

    state: Callable[..., State]
    reference: Callable[..., Reference]
    command: Callable[..., Command]


class ServoAxes(Mechanism[Settings, State, Reference, Command]):
    """Reads, checks, limits and commands joints; a mechanism adds what they move.

    A stop in mid-motion slows the joints down under the limits' acceleration; a law's own motion
    is never reshaped but for the greatest speed and the range of each joint.

    Parameters
    ----------
    joints : AxisLimits
        Names and limits, in the order of every vector.
    limits : ServoLimits
        What the loop never permits.
    servos : sequence of ServoBus
        The devices.
    emergency_stop : EmergencyStopInput, optional
        The device that reads the emergency-stop contact.
    kinds : Kinds
        The types of state, reference and command.
    period : float
        The loop's period, s.

    Raises
    ------
    ConfigurationError
        The devices do not have each joint exactly once.
    """

    brakes_itself = True

    def __init__(
        self,
        joints: AxisLimits,
        limits: ServoLimits,
        servos: Sequence[ServoBus],
        emergency_stop: EmergencyStopInput | None,
        kinds: Kinds[State, Reference, Command],
        period: float,
    ) -> None:
        self.joints = joints
        self.limits = limits
        self._servos = tuple(servos)
        self._stop_contact = StopContact(emergency_stop, limits.reading_age)
        self._kinds = kinds
        self._period = period
        self._order, self._shares = wire_axes(joints.names, self._servos)
        count = len(joints.names)
        self._still: Vector = (0.0,) * count
        self._applied: Vector | None = None
        self._speeds: Vector = self._still
        self._asked = AskedPositions(joints.names, joints.rates, limits.following, period)
        whose = {name: servo.name for servo in servos for name in servo.axis_names}
        self._stuck = StandstillWatch(
            [f"{whose[name]} joint {name}" for name in joints.names], limits.stuck
        )
        self._stop: Command | None = None
        self._are_held = False
        self._braking = False
        self._limited = False
        self._age: float
        self._largest_error = 0.0
        self._hits = {"joint range": 0, "joint rate": 0, "joint acceleration": 0}

    @classmethod
    def pick(
        cls, section: str, settings: ServoSettings, devices: Mapping[str, Device]
    ) -> tuple[list[ServoBus], EmergencyStopInput | None]:
        """Return the servo devices and the emergency stop that the settings name."""
        with DevicePicker(section, devices) as pick:
            servos = [pick("servos", name, ServoBus) for name in settings.servos]
            stop = pick.if_named("emergency_stop", settings.emergency_stop, EmergencyStopInput)
        return servos, stop

    def read(self, now: float) -> State:
        """Assemble the joints' state; see `Mechanism.read`."""
        positions: list[float] = []
        velocities: list[float] = []
        oldest = math.inf
        for servo in self._servos:
            angles, t = servo.positions()
            positions += angles
            velocities += servo.velocities().value
            if t < oldest:
                oldest, late = t, servo
        self._age = now - oldest
        most = self.limits.reading_age
        if self._age - most > 1e-9:  # times are sums of periods
            part = f"joint {late.oldest_axis}" if late.oldest_axis else ""
            raise StaleReading(late.name, self._age, most, part)
        order = self._order
        return self._kinds.state(
            now, tuple([positions[k] for k in order]), tuple([velocities[k] for k in order])
        )

    def recall(self, logged: Mapping[str, float]) -> State:
        """Assemble the joints' state from the log; see `Mechanism.recall`."""
        self._stop_contact.ignore()
        self._age = logged["reading.age"]
        names = self.joints.names
        return self._kinds.state(
            logged["clock"],
            tuple([logged[f"reading.position_{name}"] for name in names]),
            tuple([logged[f"reading.velocity_{name}"] for name in names]),
        )

    def stop_input(self) -> EmergencyStopInput | None:
        """Return the device that reads the emergency stop; see `Mechanism.stop_input`."""
        return self._stop_contact.device

    def check(self, state: State, now: float) -> None:
        """Raise if the state is not safe; see `Mechanism.check`."""
        self._stop_contact.check(now)
        if not math.isfinite(sum(state.positions)):
            raise SafetyError(f"a reading is not a number: {state.positions}")
        joints, slack = self.joints, self.limits.following
        for name, angle, lower, upper in zip(
            joints.names, state.positions, joints.lower, joints.upper, strict=True
        ):
            if not lower - slack <= angle <= upper + slack:
                raise LimitExceeded(f"position of {name}", angle, lower, upper, "rad")
        if self._applied is None:
            return
        errors = [abs(a - b) for a, b in zip(state.positions, self._applied, strict=True)]
        self._largest_error = max(errors)
        if self._largest_error > slack:
            name = joints.names[errors.index(self._largest_error)]
            raise LimitExceeded(
                f"distance of {name} from where it was sent", self._largest_error, 0.0, slack, "rad"
            )
        self._stuck.check(state.positions, self._applied, self._speeds, self._age)

    def resting_command(self, state: State) -> Command:
        """Return the command to stay; in mid-motion, to stop as soon as the limit permits."""
        if self._applied is None:
            return self._kinds.command(state.positions, self._still)
        end = self._end_of_motion()
        if end is not None:
            self._stop = self._kinds.command(end, self._still)
            return self._stop
        self._braking = True
        deceleration = self.limits.acceleration
        stop = [
            min(max(angle + 0.5 * speed * abs(speed) / deceleration, lower), upper)
            for angle, speed, lower, upper in zip(
                self._applied, self._speeds, self.joints.lower, self.joints.upper, strict=True
            )
        ]
        self._stop = self._kinds.command(tuple(stop), self._still)
        return self._stop

    def _end_of_motion(self) -> Vector | None:
        """Return where the motion leaves the joints at rest, once it is done; None in its midst.

        A stop there is the law's own last step, however abrupt it is.
        """
        return None

    def energised_command(self, state: State) -> Command:
        """Return the command to stay where the joints are."""
        return self._kinds.command(self._applied or state.positions, self._still)

    def released_command(self) -> Command:
        """Return the command to hold: a joint that is let go of would fall."""
        return self._stop or self._kinds.command(self._applied or self._still, self._still)

    def blend(self, start: Command, end: Command, share: float) -> Command:
        """Return the command `share` of the way from `start` to `end`."""
        return self._kinds.command(
            tuple(
                [a + share * (b - a) for a, b in zip(start.positions, end.positions, strict=True)]
            ),
            self._still,
        )

    def start_limiting(self, state: State) -> None:
        """Take the measured positions for those that were sent."""
        self._applied = state.positions
        self._stuck.begin(state.positions)
        self._speeds = self._still
        self._braking = False
        self._stop = None
        self._asked.restart(state.positions)

    def has_slipped(self, state: State) -> bool:
        """Return whether a brake gave way until the drives held, farther than a cycle may lead.

        Drives begin with the position that they measure; no setpoint may be far from it.
        """
        were_held, self._are_held = self._are_held, all(servo.is_enabled for servo in self._servos)
        if were_held or self._applied is None:
            return False
        return any(
            abs(position - sent) > rate * self._period
            for position, sent, rate in zip(
                state.positions, self._applied, self.joints.rates, strict=True
            )
        )

    def check_command(self, reference: Reference, command: Command) -> None:
        """See `AskedPositions.check`."""
        self._asked.check(reference.positions, command.positions)

    def limit(self, command: Command) -> Command:
        """Return the command that may be applied: each joint's range and speed."""
        before = self._applied or command.positions
        period, joints, braking = self._period, self.joints, self._braking
        applied, speeds = [], []
        for k, (wanted, was, lower, upper, fastest) in enumerate(
            zip(command.positions, before, joints.lower, joints.upper, joints.rates, strict=True)
        ):
            if not math.isfinite(wanted):
                raise LimitExceeded(
                    f"commanded position of {joints.names[k]}", wanted, lower, upper, "rad"
                )
            inside = float(wanted)  # half precision would go on through all that follows
            if not lower <= wanted <= upper:
                inside = min(max(wanted, lower), upper)
                self._hits["joint range"] += 1
            speed = (inside - was) / period
            if braking:
                speed = self._slow_down(speed, self._speeds[k], inside - was)
            if abs(speed) > fastest:
                if abs(speed) > fastest * (1.0 + 1e-6):
                    self._hits["joint rate"] += 1
                speed = math.copysign(fastest, speed)
            position = was + speed * period
            if braking:  # the range comes before a gentle stop
                position = min(max(position, lower), upper)
                speed = (position - was) / period
            speeds.append(speed)
            applied.append(position)
        self._applied, self._speeds = tuple(applied), tuple(speeds)
        self._limited = True
        return self._kinds.command(self._applied, self._speeds)

    def _slow_down(self, speed: float, before: float, distance: float) -> float:
        """Return the speed towards a place to rest, under the limit of acceleration.

        It is the greatest from which the way that is left is enough for speeds that fall by one
        step a period: n of them go (n + 1) u - n (n + 1) / 2 steps of way in all.
        """
        step = self.limits.acceleration * self._period
        left = abs(distance) / self._period
        falls = int(0.5 * (math.sqrt(1.0 + 8.0 * left / step) - 1.0) + 1e-9)
        safe = left / (falls + 1) + 0.5 * step * falls
        wanted = math.copysign(min(abs(speed), safe), distance)
        allowed = min(max(wanted, before - step), before + step)
        if allowed != speed:
            self._hits["joint acceleration"] += 1
        return allowed

    def write(self, applied: Command) -> None:
        """Hand the positions to the drives as this cycle's setpoints, if they went through `limit`.

        Else there is a fault: the drives slow down from the setpoints that they had.
        """
        if not self._limited:
            return
        self._limited = False
        positions = applied.positions
        for servo, share in zip(self._servos, self._shares, strict=True):
            servo.command_positions(tuple([positions[k] for k in share]))

    def joint_row(
        self, state: State, reference: Reference, command: Command, applied: Command
    ) -> tuple[float, ...]:
        """Return this cycle's values for `servo_columns`."""
        return (
            *state.positions,
            *state.velocities,
            self._age,
            *reference.positions,
            *reference.velocities,
            *command.positions,
            *command.velocities,
            *applied.positions,
            *applied.velocities,
        )

    def reference_of(self, state: State) -> Reference:
        """Return the reference to stay where the joints are."""
        return self._kinds.reference(self._applied or state.positions, self._still, False)

    @staticmethod
    def approach_joints(
        kind: Callable[..., Reference], start: Reference, end: Reference, duration: float, t: float
    ) -> Reference:
        """Return the minimum-jerk way between two postures at `t`, as a reference of a kind."""
        moves = [
            minimum_jerk(a, b, duration, t)
            for a, b in zip(start.positions, end.positions, strict=True)
        ]
        return kind(
            tuple([position for position, _, _ in moves]),
            tuple([velocity for _, velocity, _ in moves]),
            False,
        )

    def worst_margin(self, state: State, applied: Command, now: float) -> Margin:
        """Return the quantity that is nearest to its limit."""
        joints = self.joints
        return min(
            Margin("following error", 1.0 - self._largest_error / self.limits.following),
            Margin("reading age", 1.0 - self._age / self.limits.reading_age),
            *(
                Margin(f"{name} range", min(angle - lower, upper - angle) / (upper - lower) * 2.0)
                for name, angle, lower, upper in zip(
                    joints.names, state.positions, joints.lower, joints.upper, strict=True
                )
            ),
            *(
                Margin(f"{name} rate", 1.0 - abs(speed) / fastest)
                for name, speed, fastest in zip(
                    joints.names, self._speeds, joints.rates, strict=True
                )
            ),
            key=lambda margin: margin.fraction,
        )

    def limit_hits(self) -> dict[str, int]:
        """Return how often each limit was hit since the start."""
        return self._hits
