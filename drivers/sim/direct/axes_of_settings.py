"""From what servo drivers' settings say of their joints to simulated joints."""

from collections.abc import Mapping, Sequence

from drivers.servos.axis_settings import AxisSettings, FollowingAxisSettings
from drivers.sim.direct.servos import SimulatedServos
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed, Settings
from rig.hal import Clock


def simulate_axes(
    of: Installed[Settings, ServoPort],
    joints: Mapping[str, FollowingAxisSettings],
    steps_per_turn: Sequence[float],
    clock: Clock,
    kind: type[SimulatedServos] = SimulatedServos,
) -> SimulatedServos:
    """Return simulated joints with the limits of drives that watch their following.

    Parameters
    ----------
    of : Installed
        The device.
    joints : mapping of str to FollowingAxisSettings
        Of its settings.
    steps_per_turn : sequence of float
        Of each drive's encoder.
    clock : Clock
        The rig's.
    kind : type
        Of the device.
    """
    return kind(
        of.name,
        joints,
        of.plant,
        of.channels,
        clock,
        [
            1.0 / abs(joint.turns_per_radian * steps)
            for joint, steps in zip(joints.values(), steps_per_turn, strict=True)
        ],
    )


def signed_gear(joint: AxisSettings) -> float:
    """Return the turns of a drive's shaft for one turn of its joint, with their sign."""
    return -joint.gear if joint.reversed else joint.gear
