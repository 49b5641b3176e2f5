"""From the settings of servo drivers to the simulated drives on their other side."""

from collections.abc import Mapping, Sequence
from typing import Any

from drivers.cia402.settings import Cia402Settings, DriveSettings
from drivers.odrive.settings import OdriveAxisSettings, OdriveEndpoints, OdriveSettings
from drivers.servos.axis_settings import AxisSettings
from drivers.sim.direct.servos import SimulatedServos
from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.odrive import (
    SHIPPED_ENCODER,
    SHIPPED_HEARTBEAT,
    STEPS_PER_TURN,
    EmulatedOdrive,
)
from rig.hal import Clock


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
    writes_heartbeat = numbers is not None and numbers.heartbeat_period is not None
    writes_encoder = numbers is not None and numbers.encoder_period is not None
    return tuple(
        EmulatedOdrive(
            f"{name}.{joint}",
            axis.axis,
            plant,
            channel,
            gear=signed_gear(axis),
            zero=axis.offset,
            serial=serial if axis.serial is None else axis.serial,
            watchdog=settings.watchdog if numbers is None else 0.0,
            heartbeat=SHIPPED_HEARTBEAT if writes_heartbeat else settings.heartbeat,
            encoder_period=SHIPPED_ENCODER if writes_encoder else settings.encoder_period,
            endpoints={} if numbers is None else _endpoints(numbers),
        )
        for (joint, axis), channel in zip(settings.joints.items(), channels, strict=True)
    )


def _endpoints(numbers: OdriveEndpoints) -> dict[str, int]:
    made = {
        "axis0.config.enable_watchdog": numbers.enable_watchdog,
        "axis0.config.watchdog_timeout": numbers.watchdog_timeout,
        "axis0.config.can.heartbeat_msg_rate_ms": numbers.heartbeat_period,
        "axis0.config.can.encoder_msg_rate_ms": numbers.encoder_period,
    }
    return {path: number for path, number in made.items() if number is not None}


def simulate_cia402(
    name: str, settings: Cia402Settings, plant: Any, channels: tuple[int, ...], clock: Clock
) -> SimulatedServos:
    """Return simulated joints with the resolution and limits of the drives'."""
    return _simulate(
        name,
        settings.joints,
        [drive.counts_per_turn for drive in settings.joints.values()],
        plant,
        channels,
        clock,
    )


def simulate_odrive(
    name: str, settings: OdriveSettings, plant: Any, channels: tuple[int, ...], clock: Clock
) -> SimulatedServos:
    """Return simulated joints with the limits of the axes', and the emulated encoders' steps."""
    return _simulate(
        name,
        settings.joints,
        [float(STEPS_PER_TURN)] * len(settings.joints),
        plant,
        channels,
        clock,
    )


def _simulate(
    name: str,
    joints: Mapping[str, DriveSettings] | Mapping[str, OdriveAxisSettings],
    steps_per_turn: Sequence[float],
    plant: Any,
    channels: tuple[int, ...],
    clock: Clock,
) -> SimulatedServos:
    settings: list[DriveSettings | OdriveAxisSettings] = [*joints.values()]
    return SimulatedServos(
        name,
        joints,
        plant,
        channels,
        clock,
        resolutions=[
            1.0 / abs(joint.turns_per_radian * steps)
            for joint, steps in zip(settings, steps_per_turn, strict=True)
        ],
        decelerations=[joint.deceleration for joint in settings],
        windows=[joint.following_window for joint in settings],
        times=[joint.following_time for joint in settings],
    )


def signed_gear(joint: AxisSettings) -> float:
    """Return the turns of a drive's shaft for one turn of its joint, with their sign."""
    return -joint.gear if joint.reversed else joint.gear
