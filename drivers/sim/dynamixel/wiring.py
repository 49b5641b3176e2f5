"""From a driver's settings to the emulated servos on its other side.

The settings say how the servos are mounted: ids, gears, offsets. They are data; what the
servos make of them is their own.
"""

from drivers.dynamixel.settings import DynamixelSettings
from drivers.servos.axis_settings import FollowingAxisSettings
from drivers.sim.axis_lines import correct_axes, perturb_axes
from drivers.sim.direct.axes_of_settings import signed_gear, simulate_axes
from drivers.sim.direct.servos import SimulatedServos
from drivers.sim.dynamixel.chain import Station
from drivers.sim.dynamixel.control_table import HOMING_OFFSET
from drivers.sim.dynamixel.device import EmulatedDynamixel
from drivers.sim.dynamixel.servo import EmulatedServo, Mounting
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock

_STEPS_PER_TURN = 4096
_AT_ONCE = 1e3
"""rad/s²: from the fastest a servo turns to rest within a period."""
_TWIN_OFFSET = 0.5  # rad: a second servo with the same id stands somewhere else


class _FreeJoint(ServoPort):
    """A joint that nothing is fixed to: where a servo turns that belongs elsewhere."""

    def __init__(self, angle: float) -> None:
        self._angle = angle

    def command_joint(
        self, channel: int, position: float, velocity: float, torque_on: bool
    ) -> None:
        """Do nothing."""

    def limit_joint(self, channel: int, speed: float, torque: float) -> None:
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


def emulate_dynamixel(of: Installed[DynamixelSettings, ServoPort]) -> tuple[EmulatedDynamixel]:
    """Return emulated servos, mounted as the driver's settings say."""
    settings = of.built
    wired = dict(zip(settings.joints, of.channels, strict=True))

    def make(name: str, plant: ServoPort) -> EmulatedServo:
        joint = settings.joints[name]
        model = settings.model_of(joint)
        servo = EmulatedServo(
            joint.id,
            plant,
            wired[name],
            Mounting(signed_gear(joint), joint.offset),
            model=model.number,
            indirect_data=model.indirect_data,
        )
        servo.table[HOMING_OFFSET] = joint.homing_offset
        return servo

    def make_twin(name: str) -> EmulatedServo:
        return make(name, _FreeJoint(of.plant.joint_position(wired[name]) + _TWIN_OFFSET))

    stations = {joint: Station(make(joint, of.plant)) for joint in settings.joints}
    return (EmulatedDynamixel(of.name, stations, make_twin),)


def simulate_dynamixel(
    of: Installed[DynamixelSettings, ServoPort], clock: Clock
) -> SimulatedServos:
    """Return simulated joints with the servos' resolution and limits.

    A servo that is told to hold does so at once, with all the torque that it has.
    """
    settings = of.settings
    joints = {
        name: FollowingAxisSettings(
            gear=joint.gear,
            reversed=joint.reversed,
            limits=joint.limits,
            max_speed=joint.max_speed,
            deceleration=_AT_ONCE,
            following_window=settings.following_window,
            following_time=settings.following_time,
        )
        for name, joint in settings.joints.items()
    }
    return simulate_axes(of, joints, [_STEPS_PER_TURN] * len(joints), clock)


WIRING = Wiring(emulate_dynamixel, simulate_dynamixel, correct_axes, perturb_axes)
