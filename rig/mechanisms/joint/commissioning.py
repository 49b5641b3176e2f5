"""The acceptance test of the spherical joint."""

from collections.abc import Sequence
from dataclasses import replace
from math import pi, radians
from typing import Final

from controllers.spherical_joint.exact_wire import ExactWires
from controllers.spherical_joint.poses import axis_from_tilt, natural_rotation
from rig.assembly import REGISTRY
from rig.commissioning.bench import StepBench
from rig.commissioning.forms import one_of
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.motion import FirstMotion, Moved, by_law
from rig.config import Profile
from rig.hal import DevicePicker, LinearEncoder
from rig.mechanisms.joint.first_gains import FIRST_LAW, with_first_law
from rig.mechanisms.joint.references.poses import JointPose, JointPoses
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.commissioning.course import following, pneumatic_course
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_TILT: Final = radians(4.6)
"""Of the first motion: a wire goes 2 mm."""
_TRAVEL: Final = 2e-3
"""How far the rod of that wire goes, m: less is lost in what friction leaves of a pose."""
_SECTORS: Final = 16
"""Directions in which the ring is tilted on paper, once round."""
_LOOK: Final = 0.1
"""For so long the encoders are looked at, s."""


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    there_and_back = JointPoses((JointPose(0.0), JointPose(_TILT), JointPose(0.0)), 2.0, 1.0)
    view = REGISTRY.load("mechanism", "joint")
    rods = tuple(f"reading.rod_{channel}" for channel in view.channels)
    return pneumatic_course(
        FirstMotion(
            Moved(rods, _TRAVEL, "m"),
            by_law("poses", there_and_back, FIRST_LAW),
            prepared=lambda site: with_first_law(_from_upright(site)),
            strays=following,
        ),
        _way,
    )


def _way(settings: PneumaticSettings) -> float:
    """Return how far a rod goes from home where the profile permits the ring to tilt most, m."""
    assert isinstance(settings, JointSettings)
    wires = ExactWires(settings.geometry)
    upright = wires.lengths(natural_rotation(axis_from_tilt(0.0, 0.0)))
    ways = [
        abs(length - home)
        for k in range(_SECTORS)
        for length, home in zip(
            wires.lengths(
                natural_rotation(axis_from_tilt(settings.limits.tilt, 2.0 * pi * k / _SECTORS))
            ),
            upright,
            strict=True,
        )
    ]
    return max(ways)


_UPRIGHT: Final = Task(
    "first-motion.upright",
    "Set the ring upright, by its jig or by eye, with every wire straight; is it (yes)?",
    lambda world: "yes",
    one_of("yes"),
)


def _from_upright(site: Site) -> Profile:
    """Return a profile that calls home what the encoders show of a ring that stands upright.

    The camera is left out: where it hangs is found by a calibration.
    """
    profile = site.profile
    settings = profile.mechanism_settings
    rig = site.make_rig(profile)
    with rig:
        rig.arm(torque=False)
        site.operator.do(_UPRIGHT, site.world_of(rig))
        site.operator.answer(_UPRIGHT)
        StepBench(rig).run(_LOOK)
        pick = DevicePicker("commissioning", rig.devices)
        shown = {
            name: pick("encoder", name, LinearEncoder).position().value[0]
            for name in settings.encoders
        }
    devices = {name: entry for name, entry in profile.devices.items() if name != settings.camera}
    for name, position in shown.items():
        entry = devices[name]
        offset = entry.settings.offset + settings.home - position
        zeroed = replace(entry.settings, offset=offset)
        devices[name] = replace(entry, settings=zeroed, uncalibrated=entry.nominal)
    return replace(profile, devices=devices, mechanism_settings=replace(settings, camera=None))
