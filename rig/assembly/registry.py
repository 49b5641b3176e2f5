"""The names that profiles and experiments may use, and the classes behind them.

Names map to ``"module:class"``; a class is imported when a profile uses it. Other packages
add theirs through the entry-point groups ``rig.drivers``, ``rig.controllers``,
``rig.mechanisms``, ``rig.plants`` and ``rig.references``; no import has a side effect.
"""

import functools
import importlib
from importlib.metadata import entry_points
from typing import Any, NamedTuple

from rig.config.registry import Kind


class _Class(NamedTuple):
    """Where a class and its settings are; settings apart where the class is slow to import."""

    path: str
    settings: str | None = None


_TABLE: dict[Kind, dict[str, _Class]] = {
    "bus": {
        "canopen": _Class(
            "drivers.canopen.bus:CanopenBus", "drivers.canopen.settings:CanBusSettings"
        ),
        "cansimple": _Class(
            "drivers.servos.odrive_bus:OdriveBus",
            "drivers.servos.odrive_settings:OdriveBusSettings",
        ),
        "dynamixel": _Class(
            "drivers.dynamixel.bus:SerialBus", "drivers.dynamixel.settings:SerialBusSettings"
        ),
    },
    "driver": {
        "cia401": _Class(
            "drivers.regulators.cia401:Cia401Regulators",
            "drivers.regulators.cia401_settings:Cia401Settings",
        ),
        "cia406": _Class(
            "drivers.encoders.cia406:Cia406Encoder",
            "drivers.encoders.cia406_settings:Cia406Settings",
        ),
        "marker-camera": _Class(
            "drivers.cameras.marker_camera:MarkerCameraDriver",
            "drivers.cameras.settings:MarkerCameraSettings",
        ),
        "cia402": _Class(
            "drivers.servos.cia402:Cia402Servos",
            "drivers.servos.cia402_settings:Cia402Settings",
        ),
        "odrive": _Class(
            "drivers.servos.odrive:OdriveServos",
            "drivers.servos.odrive_settings:OdriveSettings",
        ),
        "dynamixel": _Class(
            "drivers.dynamixel.servos:DynamixelServos",
            "drivers.dynamixel.settings:DynamixelSettings",
        ),
    },
    "controller": {
        "cylinder/pid": _Class("controllers.cylinder.pid:Pid"),
        "cylinder/pid-friction": _Class("controllers.cylinder.pid_friction:PidFriction"),
        "cylinder/cascade": _Class("controllers.cylinder.cascade:Cascade"),
        "cylinder/super-twisting": _Class("controllers.cylinder.super_twisting:SuperTwisting"),
        "joint/pid": _Class("controllers.spherical_joint.laws:JointPid"),
        "joint/pid-friction": _Class("controllers.spherical_joint.laws:JointPidFriction"),
        "joint/cascade": _Class("controllers.spherical_joint.laws:JointCascade"),
        "joint/super-twisting": _Class("controllers.spherical_joint.laws:JointSuperTwisting"),
        "arm/inverse": _Class("controllers.arm.plain:Inverse"),
        "arm/dls": _Class("controllers.arm.plain:DampedLeastSquares"),
        "arm/servo-halt": _Class("controllers.arm.plain:ServoHalt"),
        "arm/esc-paper": _Class("controllers.arm.esc:EscPaper"),
        "arm/esc": _Class("controllers.arm.esc:Esc"),
        "arm/look-ahead": _Class("controllers.arm.look_ahead:LookAhead"),
        "legs/inverse": _Class("controllers.gait.laws:InverseLaw"),
        "legs/sc": _Class("controllers.gait.laws:LimitedNormLaw"),
        "legs/sc-trapezoid": _Class("controllers.gait.laws:TrapezoidNormLaw"),
        "legs/min-jerk": _Class("controllers.gait.laws:MinimumJerkLaw"),
        "legs/clamp": _Class("controllers.gait.clamped_and_damped:ClampedLaw"),
        "legs/dls": _Class("controllers.gait.clamped_and_damped:DampedLaw"),
        "legs/mink": _Class("controllers.gait.mink_rival:MinkLaw"),
    },
    "mechanism": {
        "cylinder": _Class(
            "rig.mechanisms.cylinder:AntagonisticPair",
            "rig.mechanisms.cylinder_settings:CylinderSettings",
        ),
        "joint": _Class(
            "rig.mechanisms.joint:SphericalJoint", "rig.mechanisms.joint_settings:JointSettings"
        ),
        "arm": _Class("rig.mechanisms.arm:Arm", "rig.mechanisms.arm_settings:ArmSettings"),
        "legs": _Class("rig.mechanisms.legs:Legs", "rig.mechanisms.legs_settings:LegsSettings"),
    },
    "plant": {
        "antagonistic-pair": _Class(
            "drivers.sim.plants.antagonistic_pair:AntagonisticPairPlant",
            "drivers.sim.plants.settings:PlantSettings",
        ),
        "spherical-joint": _Class(
            "drivers.sim.plants.spherical_joint:SphericalJointPlant",
            "drivers.sim.plants.spherical_joint_settings:SphericalJointPlantSettings",
        ),
        "arm": _Class(
            "drivers.sim.plants.arm:ArmPlant", "drivers.sim.plants.arm_settings:ArmPlantSettings"
        ),
        "legs": _Class(
            "drivers.sim.plants.legs:LegsPlant",
            "drivers.sim.plants.legs_settings:LegsPlantSettings",
        ),
    },
    "reference": {
        "sine": _Class(
            "rig.experiment.references.pair:Sine", "rig.experiment.references.pair:Sine"
        ),
        "staircase": _Class(
            "rig.experiment.references.pair:Staircase", "rig.experiment.references.pair:Staircase"
        ),
        "step": _Class(
            "rig.experiment.references.pair:Step", "rig.experiment.references.pair:Step"
        ),
        "ramp": _Class(
            "rig.experiment.references.pair:Ramp", "rig.experiment.references.pair:Ramp"
        ),
        "joint-circle": _Class(
            "rig.experiment.references.joint_circle:JointCircle",
            "rig.experiment.references.joint_circle:JointCircle",
        ),
        "arm-turnback": _Class("controllers.arm.paths:TurnBack", "controllers.arm.paths:TurnBack"),
        "arm-dwell": _Class("controllers.arm.paths:DwellLine", "controllers.arm.paths:DwellLine"),
        "arm-circle": _Class("controllers.arm.paths:Circle", "controllers.arm.paths:Circle"),
        "arm-line": _Class("controllers.arm.paths:Line", "controllers.arm.paths:Line"),
        "legs-walk": _Class(
            "controllers.gait.motions:WalkSettings", "controllers.gait.motions:WalkSettings"
        ),
        "legs-squat": _Class(
            "controllers.gait.motions:SquatSettings", "controllers.gait.motions:SquatSettings"
        ),
        "joint-poses": _Class(
            "rig.experiment.references.joint_poses:JointPoses",
            "rig.experiment.references.joint_poses:JointPoses",
        ),
        "joint-spiral": _Class(
            "rig.experiment.references.joint_sweeps:JointSpiral",
            "rig.experiment.references.joint_sweeps:JointSpiral",
        ),
        "joint-stiffness": _Class(
            "rig.experiment.references.joint_sweeps:JointStiffness",
            "rig.experiment.references.joint_sweeps:JointStiffness",
        ),
    },
}


def _load(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


@functools.cache
def _names(kind: Kind) -> tuple[str, ...]:
    """Look once: what is installed does not change while a program runs."""
    others = {point.name for point in entry_points(group=f"rig.{kind}s")}
    return tuple(sorted(others | set(_TABLE[kind])))


class InstalledClasses:
    """The registry of everything a profile or experiment may name; see `Registry`."""

    def names(self, kind: Kind) -> tuple[str, ...]:
        """Return every name of a kind, sorted."""
        return _names(kind)

    def settings(self, kind: Kind, name: str) -> type[Any]:
        """Return the settings dataclass of a name; KeyError if there is none."""
        known = _TABLE[kind].get(name)
        if known is not None and known.settings is not None:
            settings: type[Any] = _load(known.settings)
            return settings
        found: type[Any] = self.load(kind, name).Settings
        return found

    def load(self, kind: Kind, name: str) -> Any:
        """Return the class behind a name; KeyError if there is none."""
        known = _TABLE[kind].get(name)
        if known is not None:
            return _load(known.path)
        for point in entry_points(group=f"rig.{kind}s", name=name):
            return point.load()
        raise KeyError(name)


REGISTRY = InstalledClasses()
