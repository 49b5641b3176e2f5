"""From the settings of servo drivers to the simulated drives on their other side."""

from math import pi
from typing import Any

from drivers.servos.cia402_settings import Cia402Settings
from drivers.servos.joint_settings import JointSettings
from drivers.servos.odrive_settings import OdriveEndpoints, OdriveSettings
from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.odrive import EmulatedOdrive, Endpoint


def emulate_cia402(
    name: str, settings: Cia402Settings, plant: Any, channels: tuple[int, ...], serial: int
) -> tuple[EmulatedCia402, ...]:
    """Return one emulated drive per joint, mounted as the driver's settings say."""
    return tuple(
        EmulatedCia402(
            f"{name}.{joint}",
            drive.node,
            plant,
            channel,
            counts_per_turn=drive.counts_per_turn,
            gear=signed_gear(drive),
            zero=drive.offset,
            velocity_units=drive.velocity_units,
            acceleration_units=drive.acceleration_units,
            serial=serial if drive.serial is None else drive.serial,
        )
        for (joint, drive), channel in zip(settings.joints.items(), channels, strict=True)
    )


def emulate_odrive(
    name: str, settings: OdriveSettings, plant: Any, channels: tuple[int, ...], serial: int
) -> tuple[EmulatedOdrive, ...]:
    """Return one emulated axis per joint, mounted and set up as the driver's settings say."""
    numbers = settings.endpoints
    # What the driver can write is as the maker ships it; the rest was set by hand.
    endpoints = {} if numbers is None else _endpoints(numbers)
    by_hand = {"watchdog": settings.watchdog} if numbers is None else {}
    if numbers is None or numbers.heartbeat_period is None:
        by_hand["heartbeat"] = settings.heartbeat
    if numbers is None or numbers.encoder_period is None:
        by_hand["encoder_period"] = settings.encoder_period
    return tuple(
        EmulatedOdrive(
            f"{name}.{joint}",
            axis.axis,
            plant,
            channel,
            gear=signed_gear(axis),
            zero=axis.offset,
            serial=serial if axis.serial is None else axis.serial,
            endpoints=endpoints,
            **by_hand,
        )
        for (joint, axis), channel in zip(settings.joints.items(), channels, strict=True)
    )


def _endpoints(numbers: OdriveEndpoints) -> dict[int, Endpoint]:
    made: dict[int, Endpoint] = {
        numbers.enable_watchdog: ("enable_watchdog", "?"),
        numbers.watchdog_timeout: ("watchdog_timeout", "f"),
    }
    if numbers.heartbeat_period is not None:
        made[numbers.heartbeat_period] = ("heartbeat_msg_rate_ms", "I")
    if numbers.encoder_period is not None:
        made[numbers.encoder_period] = ("encoder_msg_rate_ms", "I")
    return made


def signed_gear(joint: JointSettings) -> float:
    """Return the turns of a drive's shaft for one turn of its joint, with their sign."""
    return -joint.gear if joint.reversed else joint.gear


def resolution_of(joint: JointSettings, steps_per_turn: float) -> float:
    """Return the angle of one step of a drive at its joint, rad."""
    return 2.0 * pi / (steps_per_turn * joint.gear)
