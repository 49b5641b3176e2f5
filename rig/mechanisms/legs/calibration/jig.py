"""Legs in a jig: without torque, held at angles that are known to the jig's tolerance."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, ClassVar, Final

import numpy as np

from controllers.gait.geometry import AXIS_NAMES
from controllers.gait.types import LegsCommand, LegsReference
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate
from rig.calibration.instruments import Instrument, Readings
from rig.calibration.procedure import Excitation, Finding, Panel, Procedure
from rig.calibration.profile_changes import profile_with
from rig.calibration.recording import CalibrationRefused, Recording, Stretch
from rig.config import Profile
from rig.mechanisms.servo.calibration.posture_moves import Postures, PostureScript

_ROOM: Final = 4.0 * math.pi
"""By how much a reading may be outside its limits, rad: any way that a horn can be mounted."""
_LOOSE: Final = 2e-3
"""By how much a joint that a jig holds may move, beside two counts, rad."""


def devices_of(profile: Profile) -> tuple[str, ...]:
    """Return the servo devices."""
    return tuple(profile.mechanism_settings.servos)


def jig_poses(profile: Profile, count: int | None = None) -> dict[str, tuple[float, ...]]:
    """Return the angles of all twelve joints in each pose of the jig, rad.

    Parameters
    ----------
    profile : Profile
        The legs'.
    count : int, optional
        So many of them, the first ones.
    """
    settings = profile.mechanism_settings
    mirror = settings.geometry.mirror
    poses = list(settings.jig.poses.items())[:count]
    return {
        name: (*(sign * angle for sign, angle in zip(mirror, left, strict=True)), *left)
        for name, left in poses
    }


def instruments_of(profile: Profile, poses: dict[str, tuple[float, ...]]) -> list[Instrument]:
    """Return the jig as what tells each joint's angle; an inclinometer may tell it better."""
    tolerance = profile.mechanism_settings.jig.tolerance
    return [
        Instrument(
            f"angle {joint}", "rad", tolerance, tuple(poses), joint,
            tuple(pose[k] for pose in poses.values()),
        )
        for k, joint in enumerate(AXIS_NAMES)
    ]  # fmt: skip


def excite(
    profile: Profile, poses: dict[str, tuple[float, ...]], done: Sequence[str]
) -> Excitation:
    """Return the first pose that is not done: nothing moves, and nobody holds anything."""
    settings = profile.mechanism_settings
    left = [name for name in poses if name not in done]
    name = left[0] if left else ""
    postures = Postures(
        (name,), AXIS_NAMES, ((0.0,) * len(AXIS_NAMES),), settings.jig.dwell,
        settings.jig.dwell, relative=True,
    )  # fmt: skip
    script = PostureScript(
        postures, (1.0,) * len(AXIS_NAMES), settings.geometry.limits,
        reference=LegsReference, command=LegsCommand, has_torque=False,
    )  # fmt: skip
    wider = profile_with(profile, {f"{profile.mechanism}.limits.following": _ROOM})
    if profile.plant is not None and name:  # a simulated robot is put where a real one is
        wider = profile_with(wider, {"plant.stand": poses[name]})
    notes = (
        "limits.following is not in force: there is no torque, and the zeros that the joints' "
        "limits rest on are what is looked for",
    )
    return Excitation(
        postures, script, script, "joint-moves", wider, script.describe, notes, approach=0.1,
        placing=f"put both legs into the jig's pose {name!r}, without torque" if name else "",
    )  # fmt: skip


class JigProcedure(Procedure[Recording]):
    """Base of what is found with both legs in the jig."""

    pose_count: ClassVar[int | None] = None
    """How many of the jig's poses it needs, the first ones; None: all."""

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the servo devices' files."""
        return devices_of(profile)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return the jig in these poses."""
        return instruments_of(profile, jig_poses(profile, self.pose_count))

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the jig's next pose."""
        return excite(profile, jig_poses(profile, self.pose_count), done)


def measured(
    poses: dict[str, tuple[float, ...]], recording: Recording, readings: Readings, steps: Array
) -> tuple[Array, Array]:
    """Return what the encoders read and what the jig says, each (poses, 12), rad.

    Parameters
    ----------
    poses, recording, readings
        What was to be done, and what was.
    steps : ndarray, shape (12,)
        Of the encoders, rad.

    Raises
    ------
    CalibrationRefused
        A pose is missing, or a joint moved in it.
    """
    recording.require(poses)
    for name in poses:
        _check_still(name, recording[name], steps)
    for joint in AXIS_NAMES:
        lacking = [name for name in poses if name not in readings.get(f"angle {joint}", {})]
        if lacking:
            raise CalibrationRefused(f"nobody says the angle of {joint} in {lacking[0]!r}")
    read = [[recording[n].mean(f"reading.position_{j}") for j in AXIS_NAMES] for n in poses]
    said = [[readings[f"angle {joint}"][name] for joint in AXIS_NAMES] for name in poses]
    return np.array(read), np.array(said)


def _check_still(name: str, stretch: Stretch, steps: Array) -> None:
    for joint, step in zip(AXIS_NAMES, steps.tolist(), strict=True):
        moved = float(np.ptp(stretch[f"reading.position_{joint}"]))
        if moved > _LOOSE + 2.0 * step:
            raise CalibrationRefused(
                f"{joint} moved by {moved:.3g} rad in {name!r}: it is loose in the jig, or "
                "somebody touched it"
            )


def settings_of(profile: Profile) -> list[tuple[str, Any]]:
    """Return of each joint its device and its settings, in the order of the joints."""
    found = {
        joint: (device, settings)
        for device in devices_of(profile)
        for joint, settings in profile.devices[device].settings.joints.items()
    }
    return [found[joint] for joint in AXIS_NAMES]


def steps_of(profile: Profile) -> Array:
    """Return the steps of the encoders, rad; 0 where they are not known."""
    steps = {
        joint: profile.devices[device].settings.resolution(joint)
        for device in devices_of(profile)
        for joint in profile.devices[device].settings.joints
    }
    return np.array([steps[joint] for joint in AXIS_NAMES])


def findings(
    profile: Profile,
    values: Sequence[dict[str, Any]],
    estimates: Sequence[Sequence[Estimate]],
    residuals: Array,
    bound: float,
    panels: Sequence[Panel],
) -> list[Finding]:
    """Return a finding per device.

    Parameters
    ----------
    profile : Profile
        The legs'.
    values, estimates : sequence
        Of each joint.
    residuals : ndarray, shape (n, 12)
        rad.
    bound : float
        Of their rms, rad.
    panels : sequence of Panel
        For the page.

    Raises
    ------
    CalibrationRefused
        The device's settings do not permit a value.
    """
    found = []
    joints = settings_of(profile)
    for number, device in enumerate(devices_of(profile)):
        mine = [k for k, (owner, _) in enumerate(joints) if owner == device]
        _check(device, profile.devices[device].settings, {AXIS_NAMES[k]: values[k] for k in mine})
        written = {AXIS_NAMES[k]: _written(values[k]) for k in mine}
        found.append(
            Finding(
                device, {"joints": written}, tuple(e for k in mine for e in estimates[k]),
                residuals[:, mine].ravel(), "rad", bound, residuals[:, mine].size,
                panels if number == 0 else (),
            )
        )  # fmt: skip
    return found


def _written(values: dict[str, Any]) -> dict[str, Any]:
    angle = f"{values['offset']:.9g} rad"
    return {**{k: float(f"{v:.9g}") if k == "gear" else v for k, v in values.items()},
            "offset": angle}  # fmt: skip


def _check(device: str, settings: Any, values: dict[str, dict[str, Any]]) -> None:
    try:
        joints = {
            name: dataclasses.replace(joint, **values.get(name, {}))
            for name, joint in settings.joints.items()
        }
        dataclasses.replace(settings, joints=joints)
    except ValueError as error:
        raise CalibrationRefused(
            f"{device}: with what was found its settings are none: {error} Mount the horn so that "
            "the joint's range is the servo's"
        ) from error
