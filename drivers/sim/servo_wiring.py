"""From the settings of servo drivers to the simulated drives on their other side."""

from math import pi
from typing import Any

from drivers.servos.cia402_settings import Cia402Settings
from drivers.servos.joint_settings import JointSettings
from drivers.sim.nodes.cia402 import EmulatedCia402


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


def signed_gear(joint: JointSettings) -> float:
    """Return the turns of a drive's shaft for one turn of its joint, with their sign."""
    return -joint.gear if joint.reversed else joint.gear


def resolution_of(joint: JointSettings, steps_per_turn: float) -> float:
    """Return the angle of one step of a drive at its joint, rad."""
    return 2.0 * pi / (steps_per_turn * joint.gear)
