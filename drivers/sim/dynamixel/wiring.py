"""From a driver's settings to the emulated servos on its other side.

The settings say how the servos are mounted: ids, gears, offsets. They are data; what the
servos make of them is their own.
"""

from math import tau
from typing import Any

from drivers.dynamixel.settings import DynamixelJoint, DynamixelSettings
from drivers.sim.dynamixel.chain import Station
from drivers.sim.dynamixel.control_table import HOMING_OFFSET
from drivers.sim.dynamixel.device import EmulatedDynamixel
from drivers.sim.dynamixel.servo import EmulatedServo, JointPort, Mounting


class _FreeJoint:
    """A joint that nothing is fixed to: where a servo turns that belongs elsewhere."""

    def __init__(self, angle: float) -> None:
        self._angle = angle

    def command_joint(
        self, channel: int, position: float | None, velocity: float, torque_on: bool
    ) -> None:
        """Do nothing."""

    def joint_position(self, channel: int) -> float:
        """Return its angle, rad."""
        return self._angle

    def joint_velocity(self, channel: int) -> float:
        """Return 0."""
        return 0.0

    def joint_torque(self, channel: int) -> float:
        """Return 0."""
        return 0.0


def emulate_dynamixel(
    name: str,
    settings: DynamixelSettings,
    plant: Any,
    channels: tuple[int, ...],
    serial: int = 0,
) -> EmulatedDynamixel:
    """Return emulated servos, mounted as the driver's settings say.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    settings : DynamixelSettings
        The driver's.
    plant : JointPort
        The physics.
    channels : tuple of int
        The plant's joints, in the order of the device's.
    serial : int
        Not used: these servos have no serial number.
    """
    joints = tuple(settings.joints.values())

    def make(k: int, plant: JointPort) -> EmulatedServo:
        joint = joints[k]
        model = settings.model_of(joint)
        servo = EmulatedServo(
            joint.id,
            plant,
            channels[k],
            _mounting(joint),
            model=model.number,
            indirect_data=model.indirect_data,
        )
        servo.table[HOMING_OFFSET] = joint.homing_offset
        return servo

    def make_twin(k: int, offset: float) -> EmulatedServo:
        return make(k, _FreeJoint(plant.joint_position(channels[k]) + offset))

    return EmulatedDynamixel(name, [Station(make(k, plant)) for k in range(len(joints))], make_twin)


def _mounting(joint: DynamixelJoint) -> Mounting:
    turns = joint.gear / tau
    return Mounting(-turns if joint.reversed else turns, joint.offset)
