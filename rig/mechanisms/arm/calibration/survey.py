"""An arm that is measured by its hand: what both of its procedures have in common."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from controllers.arm.types import ArmCommand, ArmReference
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, interval
from rig.calibration.instruments import Instrument, Readings, shown_in
from rig.calibration.procedure import Excitation, Finding, Panel, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.arm.calibration.hand_fit import HandFit, find_unseen, jacobian
from rig.mechanisms.arm.calibration.hand_model import (
    JOINTS,
    LENGTHS,
    marker_positions,
    parameters_of,
)
from rig.mechanisms.servo.calibration.posture_moves import Postures, PostureScript

Poses = Sequence[tuple[str, tuple[float, ...]]]

_JUDGED: Final = 0.3
_SHARE: Final = 0.7
"""Of each joint's permitted speed."""
_BOUND: Final = 3.0
"""Residual above which a fit is not to be used, in the instrument's stated uncertainty."""


def devices_of(profile: Profile) -> tuple[str, ...]:
    """Return the servo devices."""
    return tuple(profile.mechanism_settings.servos)


def instruments_of(profile: Profile, poses: Poses) -> tuple[Instrument, ...]:
    """Return what measures the marker on the hand: three coordinates in every pose."""
    names = tuple(name for name, _ in poses if name)
    accuracy = profile.mechanism_settings.metrology.accuracy
    return tuple(
        Instrument(f"hand {axis}", "m", accuracy, names, f"marker_{axis}") for axis in "xyz"
    )


def excite(profile: Profile, poses: Poses, done: Sequence[str], *, relative: bool) -> Excitation:
    """Return the way through the poses that are not done."""
    settings = profile.mechanism_settings
    geometry = settings.geometry
    # What is only passed is passed again; without a pose left nothing is.
    left = [(name, q) for name, q in poses if name not in done]
    if not any(name for name, _ in left):
        left = []
    postures = Postures(
        tuple(name for name, _ in left) or ("",),
        JOINTS,
        tuple(q for _, q in left) or ((0.0,) * 6,),
        settings.metrology.dwell,
        min(_JUDGED, 0.5 * settings.metrology.dwell),
        relative,
    )
    speeds = [_SHARE * rate for rate in geometry.rate_limits]
    limits = tuple(zip(geometry.position_min, geometry.position_max, strict=True))
    script = PostureScript(postures, speeds, limits, reference=ArmReference, command=ArmCommand)
    first = postures.angles[0]
    farthest = max(
        1.875 * max(q - low, high - q) / speed
        for q, (low, high), speed in zip(first, limits, speeds, strict=True)
    )
    return Excitation(
        postures, script, script, "joint-moves", profile, script.describe, notes_of(profile, poses),
        approach=0.2 if relative else farthest,
    )  # fmt: skip


def notes_of(profile: Profile, poses: Poses) -> tuple[str, ...]:
    """Return what these poses will not tell, for the preview."""
    settings = profile.mechanism_settings
    parameters = parameters_of(settings.geometry, settings.metrology)
    readings = np.array([q for name, q in poses if name])
    start = np.array([parameter.value for parameter in parameters])
    design = jacobian(parameters, start, readings, float(settings.geometry.wrist_sign))
    try:
        _, notes = find_unseen(parameters, design, settings.metrology.accuracy)
    except CalibrationRefused as refusal:  # relative poses, whose middle is not known yet
        return (str(refusal),)
    return notes


def measured(
    profile: Profile, poses: Poses, recording: Recording, readings: Readings
) -> tuple[Array, Array]:
    """Return the joints (n, 6), rad, and the marker (n, 3), m, of every pose.

    Raises
    ------
    CalibrationRefused
        A pose was not held to its end, or not measured.
    """
    names = [name for name, _ in poses if name]
    recording.require(names)
    hand = [
        shown_in(readings, f"hand {axis}", names, f"hand {axis} was not measured", "poses")
        for axis in "xyz"
    ]
    joints = [[recording[n].mean(f"reading.position_{j}") for j in JOINTS] for n in names]
    return np.array(joints), np.column_stack(hand)


def drive_findings(
    profile: Profile,
    fit: HandFit,
    directions: Sequence[float],
    panels: Sequence[Panel],
) -> list[Finding]:
    """Return the findings of the servo devices: offset and direction of each joint."""
    found = []
    for number, device in enumerate(devices_of(profile)):
        joints = profile.devices[device].settings.joints
        values: dict[str, object] = {}
        estimates: list[Estimate] = []
        for k, name in enumerate(JOINTS):
            if name not in joints or (not fit.seen[k] and directions[k] > 0.0):
                continue
            offset = directions[k] * joints[name].offset + float(fit.values[k])
            values[name] = {
                "offset": quantity(offset, "rad"),
                "reversed": joints[name].reversed != (directions[k] < 0.0),
            }
            if fit.seen[k]:
                std = float(fit.covariance[k, k] ** 0.5)
                estimates.append(interval(f"{name}.offset", offset, "rad", std, fit.freedom))
            _check(device, joints[name], name, offset)
        shown = panels if number == 0 else ()
        found.append(_finding(profile, device, {"joints": values}, estimates, fit, shown))
    return found


def length_finding(profile: Profile, fit: HandFit) -> Finding:
    """Return the finding of the mechanism: its lengths."""
    estimates = [
        interval(name, float(fit.values[k]), "m", float(fit.covariance[k, k] ** 0.5), fit.freedom)
        for k, name in enumerate(LENGTHS, 6)
        if fit.seen[k]
    ]
    geometry = {e.name: quantity(e.value, "m") for e in estimates}
    return _finding(profile, profile.mechanism, {"geometry": geometry}, estimates, fit, ())


def panels_of(profile: Profile, fit: HandFit, joints: Array, hand: Array) -> list[Panel]:
    """Return a panel per axis: how far the hand is from where the profile has it."""
    settings = profile.mechanism_settings
    start = fit.values.copy()
    parameters = parameters_of(settings.geometry, settings.metrology)
    start[:16] = [parameter.value for parameter in parameters[:16]]
    before = marker_positions(start, joints, float(settings.geometry.wrist_sign))
    number = np.arange(1.0, len(joints) + 1.0)
    return [
        Panel(
            f"hand {axis}", "pose", "measured less profile (mm)", "residual (µm)", number,
            1e3 * (hand - before)[:, k], 1e3 * (hand - before - fit.residuals)[:, k],
            np.zeros(len(joints)), 1e3,
        )
        for k, axis in enumerate("xyz")
    ]  # fmt: skip


def _finding(
    profile: Profile,
    target: str,
    values: Mapping[str, object],
    estimates: Sequence[Estimate],
    fit: HandFit,
    panels: Sequence[Panel],
) -> Finding:
    bound = _BOUND * profile.mechanism_settings.metrology.accuracy
    return Finding(
        target, values, tuple(estimates), fit.residuals.ravel(), "m", bound,
        len(fit.residuals), panels, fit.notes,
    )  # fmt: skip


def _check(device: str, settings: Any, joint: str, offset: float) -> None:
    """Refuse an offset with which the device's settings are none."""
    try:
        dataclasses.replace(settings, offset=offset)
    except ValueError as error:
        raise CalibrationRefused(f"{device} joint {joint}: {error}") from error
