"""What a profile says of a CAN bus with ODrives on it, and of joints on them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal, Self

from annotated_types import Gt, Interval, Le, MinLen, Unit

from drivers.can.bus_settings import CanInterfaceSettings
from drivers.can.device_settings import CanDeviceSettings
from drivers.can.milliseconds import check_milliseconds
from drivers.servos.axis_settings import FollowingAxisSettings, bounds_of
from rig.hal import Address
from rig.hal.driver import AxisBounds

_FEEDFORWARD_STEPS: Final = 1000.0  # of Set_Input_Pos, per turn/s; the firmware's default
_I16: Final = 0x7FFF


@dataclass(frozen=True, slots=True)
class OdriveBusSettings(CanInterfaceSettings):
    """One CAN interface with nothing but CANSimple devices on it.

    Parameters
    ----------
    reply_timeout : float
        How long the master waits for an answer while it configures, s.
    """

    reply_timeout: Annotated[float, Unit("s"), Interval(ge=1e-3, le=10.0)] = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class OdriveAxisSettings(FollowingAxisSettings):
    """One joint with its ODrive axis.

    Parameters
    ----------
    axis : int
        The axis's node number on the bus, 0 … 62.
    serial : int, optional
        The serial number that the ODrive must report (48 bits).
    speed_limit : float, optional
        Where the ODrive itself limits its motor, turn/s. None: 15 % above `max_speed`.
    current_limit : float
        Greatest motor current, A.
    """

    axis: Annotated[int, Interval(ge=0, le=0x3E)]
    serial: Annotated[int, Interval(ge=0, lt=1 << 48)] | None = None
    speed_limit: Annotated[float, Unit("1/s"), Gt(0), Le(1000)] | None = None
    current_limit: Annotated[float, Unit("A"), Gt(0)] = 10.0

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings of an axis that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = FollowingAxisSettings.gentle(self, speed, window, effort)
        limit = self.speed_limit
        if limit is not None:
            limit = min(limit, slow.speed_cap * abs(self.turns_per_radian))
        return replace(slow, current_limit=effort * self.current_limit, speed_limit=limit)

    @property
    def motor_speed_limit(self) -> float:
        """Where the ODrive limits its motor, turn/s."""
        return self.speed_limit or self.speed_cap * abs(self.turns_per_radian)


@dataclass(frozen=True, slots=True)
class OdriveEndpoints:
    """Numbers of an ODrive's parameters, which differ from firmware to firmware.

    They stand in the ``flat_endpoints.json`` that ODrive Robotics publishes for each firmware.
    Those that are given are written and read back at each start.

    Parameters
    ----------
    enable_watchdog : int
        Of ``axis0.config.enable_watchdog``.
    watchdog_timeout : int
        Of ``axis0.config.watchdog_timeout``.
    heartbeat_period : int, optional
        Of ``axis0.config.can.heartbeat_msg_rate_ms``.
    encoder_period : int, optional
        Of ``axis0.config.can.encoder_msg_rate_ms``.
    speed_limit : int, optional
        Of ``axis0.controller.config.vel_limit``; read back only, as the next one.
    current_limit : int, optional
        Of ``axis0.config.motor.current_soft_max``.
    """

    enable_watchdog: Annotated[int, Interval(ge=0, le=0xFFFF)]
    watchdog_timeout: Annotated[int, Interval(ge=0, le=0xFFFF)]
    heartbeat_period: Annotated[int, Interval(ge=0, le=0xFFFF)] | None = None
    encoder_period: Annotated[int, Interval(ge=0, le=0xFFFF)] | None = None
    speed_limit: Annotated[int, Interval(ge=0, le=0xFFFF)] | None = None
    current_limit: Annotated[int, Interval(ge=0, le=0xFFFF)] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class OdriveSettings(CanDeviceSettings):
    """Joints on ODrives (firmware 0.6 and later), one axis each, by CANSimple.

    Every axis must have its watchdog enabled: setpoints feed it, and it takes the torque away
    when they stay away. CANSimple alone cannot read that back; with `endpoints` it is written
    and read back at each start, without them it must have been set by hand.

    Parameters
    ----------
    joints : dict of str to OdriveAxisSettings
        In the order of the joints.
    mode : str
        ``position``: the axes follow positions; ``velocity``: they follow velocities, and
        positions are held by the rig's loop.
    feedforward : bool
        In ``position``: send the setpoints' velocity as feedforward.
    feedforward_scale : float
        Steps of the velocity feedforward, s/turn: ``axis0.config.can.input_vel_scale``.
    position_gain : float
        In ``velocity``: velocity for an error in position, 1/s, where positions are commanded
        or the velocity is zero.
    watchdog : float
        ``axis0.config.watchdog_timeout``, s: about five periods of the cycle.
    heartbeat : float
        ``axis0.config.can.heartbeat_msg_rate_ms``, s.
    encoder_period : float
        ``axis0.config.can.encoder_msg_rate_ms``, s: at most the period of the cycle.
    endpoints : OdriveEndpoints, optional
        To write these three settings, and to read them and the limits back once the axis is
        armed: one that has rebooted meanwhile runs on its defaults.
    enable_time : float
        How long the axes may take to close their loops, s.
    fault_after : int
        Readings or heartbeats missed in a row that are a fault.
    """

    scaling = ("joints.*.gear", "joints.*.reversed", "joints.*.offset")

    joints: Annotated[dict[str, OdriveAxisSettings], MinLen(1)]
    mode: Literal["position", "velocity"] = "position"
    feedforward: bool = True
    feedforward_scale: Annotated[float, Unit("s"), Gt(0)] = _FEEDFORWARD_STEPS
    position_gain: Annotated[float, Unit("1/s"), Gt(0)] = 10.0
    watchdog: Annotated[float, Unit("s"), Interval(ge=0.01, le=1.0)] = 0.05
    heartbeat: Annotated[float, Unit("s"), Interval(ge=1e-3, le=1.0)] = 0.02
    encoder_period: Annotated[float, Unit("s"), Interval(ge=1e-3, le=0.1)] = 0.005
    endpoints: OdriveEndpoints | None = None
    enable_time: Annotated[float, Unit("s"), Interval(ge=1e-3, le=60.0)] = 2.0
    fault_after: Annotated[int, Interval(ge=2, le=100)] = 5

    def __post_init__(self) -> None:
        check_milliseconds("heartbeat", self.heartbeat, "heartbeat_msg_rate_ms")
        check_milliseconds("encoder_period", self.encoder_period, "encoder_msg_rate_ms")
        owner: dict[int, str] = {}
        for name, joint in self.joints.items():
            if joint.axis in owner:
                raise ValueError(
                    f"joints {owner[joint.axis]} and {name} have the same axis {joint.axis}."
                )
            owner[joint.axis] = name
            fastest = joint.max_speed * abs(joint.turns_per_radian)
            if self.feedforward and fastest * self.feedforward_scale > _I16:
                raise ValueError(
                    f"joint {name}: a feedforward of {fastest:g} turn/s does not fit into 16 "
                    f"bits in steps of 1/{self.feedforward_scale:g}; lower max_speed or "
                    "feedforward_scale, or set feedforward to false."
                )

    def axis_bounds(self) -> Mapping[str, AxisBounds]:
        """Return each joint's limits and greatest speed."""
        return bounds_of(self.joints)

    def gentle(self, speed: float, window: float, effort: float) -> Self:
        """Return the settings for axes that nobody trusts yet; see `DriverSettings.gentle`."""
        slow = {name: its.gentle(speed, window, effort) for name, its in self.joints.items()}
        return replace(self, joints=slow)

    def channel_names(self) -> tuple[str, ...]:
        """Return the joints' names, in order."""
        return tuple(self.joints)

    def acts_after(self, bus: object) -> float | None:
        """Return after how long without the program it makes itself safe, s: its watchdog."""
        return self.watchdog

    def addresses(self, device: str, serial: int | None) -> tuple[Address, ...]:
        """Return each joint's axis."""
        return tuple(
            Address(
                f"{device}.{joint}", its.axis, serial=serial if its.serial is None else its.serial
            )
            for joint, its in self.joints.items()
        )

    def cyclic_frames(self) -> tuple[tuple[str, int], ...]:
        """Return what the master sends each cycle: names and bytes."""
        frame = "Set_Input_Pos" if self.mode == "position" else "Set_Input_Vel"
        return tuple((f"{joint} {frame}", 8) for joint in self.joints)

    def timed_frames(self, heartbeat: float) -> tuple[tuple[str, int, float], ...]:
        """Return what the axes send by their own clocks: names, bytes and rates, Hz."""
        rates: Mapping[str, float] = {
            "Heartbeat": self.heartbeat,
            "Get_Encoder_Estimates": self.encoder_period,
        }
        return tuple(
            (f"{joint} {frame}", 8, 1.0 / period)
            for joint in self.joints
            for frame, period in rates.items()
        )
