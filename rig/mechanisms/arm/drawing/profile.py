"""The profile of an arm that somebody else has described."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from rig.config.plain_dump import plain_text
from rig.hal.drawn_profile import DrawnProfile
from rig.mechanisms.arm.drawing.chain import Chain, DrawingError, DrawnJoint
from rig.mechanisms.arm.drawing.spherical_wrist import Drawing, recognise

_USUAL: Final = ArmGeometry()
_WHOLE: Final = 2.0 * math.pi
_ENDLESS: Final = 100.0
"""Range of a joint that turns without end, rad: 16 turns."""
_FOLLOWING: Final = (0.15, 0.02)
"""By what a joint may be behind: as on the profile `arm` (rad), or what a fast one goes in 20 ms,
which is twice what the simulated drives lag by at a steady rate (s)."""
_POSES: Final = 200
_FARTHEST_OFF: Final = 1e-4
"""m: a hand that is so far off is no rounding of the description."""
_HARDER: Final = 5.0
"""Accelerations are so many times the greatest speeds, 1/s: no description says them."""
_POSTURE: Final = (0.0, math.radians(30), math.radians(90), 0.0, math.radians(-30), 0.0)
"""The simulated arm begins there if its ranges permit: away from every singularity."""
_WIDER: Final = math.radians(0.5)
_INERTIAS: Final = (1.2, 1.2, 0.8, 0.2, 0.2, 0.12)
_TORQUES: Final = (150.0, 150.0, 100.0, 40.0, 40.0, 30.0)
_BRAKES: Final = (200.0, 200.0, 130.0, 50.0, 50.0, 40.0)


def of_urdf(name: str, file: Path, tip: str | None) -> DrawnProfile:
    """Return the profile of an arm in a URDF; see `rig.hal.drawn_profile.Draw`."""
    from rig.mechanisms.arm.drawing.urdf import read_urdf

    return profile_of(name, read_urdf(file, tip))


def of_dh(name: str, file: Path, tip: str | None) -> DrawnProfile:
    """Return the profile of an arm given by Denavit-Hartenberg parameters."""
    from rig.mechanisms.arm.drawing.denavit_hartenberg import read_dh

    if tip is not None:
        raise DrawingError(f"{file}: a table of Denavit-Hartenberg parameters has no links to name")
    return profile_of(name, read_dh(file))


def profile_of(name: str, chain: Chain) -> DrawnProfile:
    """Return the profile of a drawn arm.

    Raises
    ------
    DrawingError
        The laws do not cover it.
    """
    drawing = recognise(chain)
    off = _furthest_off(chain, drawing)
    if off > _FARTHEST_OFF:
        raise DrawingError(
            f"{chain.source}: its hand is up to {1e3 * off:.3g} mm from where the arm would have "
            f"it whose axes are exactly parallel, at right angles and meeting"
        )
    ranges = [_range_of(chain, drawing, k) for k in range(6)]
    rates = [
        usual if joint.speed is None else joint.speed
        for joint, usual in zip(chain.joints, _USUAL.rate_limits, strict=True)
    ]
    text = "\n".join(
        (
            *_head(name, chain, drawing),
            *_devices(drawing, ranges, rates),
            *_arm(drawing, ranges, rates),
            *_plant(drawing, ranges),
        )
    )
    return DrawnProfile(text + "\n", tuple(_notes(chain, off)))


def _furthest_off(chain: Chain, drawing: Drawing) -> float:
    """Return by how much the hand differs at most in drawn poses, m."""
    arm = dimensions_of(drawing.geometry)
    poses = np.random.default_rng(0).uniform(-math.pi, math.pi, (_POSES, 6))
    off = 0.0
    for pose in poses:
        hand = np.array(forward(arm, drawing.joints_of(pose)).position)
        there, _ = chain.tip_at(pose.tolist())
        seen = drawing.base_position + drawing.base_rotation @ hand
        off = max(off, float(np.linalg.norm(seen - there)))
    return off


def _range_of(chain: Chain, drawing: Drawing, k: int) -> tuple[float, float]:
    joint, sign, zero = chain.joints[k], drawing.signs[k], drawing.zeros[k]
    if _is_endless(joint):
        return -_WHOLE, _WHOLE
    if not joint.is_ranged:
        return -math.pi, math.pi
    ends = sorted((sign * joint.lower + zero, sign * joint.upper + zero))
    return ends[0], ends[1]


def _is_endless(joint: DrawnJoint) -> bool:
    """Return whether a joint turns on and on, or is said to by a range that no cable bears."""
    return not joint.upper - joint.lower <= _ENDLESS


def _head(name: str, chain: Chain, drawing: Drawing) -> list[str]:
    lines = [
        f"# Made by `rig new rig` from {_one_line(Path(chain.source).name)}: "
        f"{_one_line(chain.base)} to {_one_line(chain.tip)}.",
        "# At zero the laws' arm stands straight up; `rig explain arm.geometry` says how q1 … q6",
        "# turn. Of the description's joints they are:",
    ]
    for axis, joint, sign, zero in zip(
        AXIS_NAMES, chain.joints, drawing.signs, drawing.zeros, strict=True
    ):
        turn = "-" if sign < 0.0 else ""
        shift = "" if _angle(abs(zero)) == "0 deg" else f" {'-' if zero < 0.0 else '+'} "
        added = _angle(abs(zero)) if shift else ""
        lines.append(f"#   {axis} = {turn}{_one_line(joint.name)}{shift}{added}")
    lines += [
        *_frame("base", drawing.base_rotation, drawing.base_position, chain.base),
        *_frame("tool", drawing.tip_rotation.T, np.zeros(3), chain.tip),
        "extends: arm",
        f"name: {plain_text(name)}",
        "description: A six-joint arm with a spherical wrist, from its description",
        "",
    ]
    return lines


def _frame(which: str, rotation: np.ndarray, position: np.ndarray, drawn: str) -> list[str]:
    """Return a comment on how a frame here stands in the drawing's, if it is not the same."""
    from scipy.spatial.transform import Rotation

    turn = np.degrees(Rotation.from_matrix(rotation).as_rotvec())
    parts = []
    if np.abs(position).max() > 1e-9:
        parts.append("at " + ", ".join(f"{1e3 * value:.6g}" for value in position) + " mm")
    if np.abs(turn).max() > 1e-4:
        vector = ", ".join(f"{value:.6g}" for value in turn.round(6) + 0.0)
        parts.append(f"turned by the rotation vector {vector} deg")
    if not parts:
        return []
    return [f"# The {which}'s frame here stands in {_one_line(drawn)} {' and '.join(parts)}."]


def _devices(
    drawing: Drawing, ranges: Sequence[tuple[float, float]], rates: Sequence[float]
) -> list[str]:
    lines = [
        "devices:",
        "  drives:",
        "    joints:  # nodes, counts and gears are those of the profile `arm`: say yours",
    ]
    for k, axis in enumerate(AXIS_NAMES):
        low, high = ranges[k]
        parts = [
            f"limits: [{_degrees(low - _WIDER)}, {_degrees(high + _WIDER)}]",
            f"max_speed: {_short(1.01 * rates[k])} rad/s",
            f"deceleration: {_short(0.8 * _HARDER * rates[k])} rad/s^2",
        ]
        if drawing.signs[k] < 0.0:
            parts.append("reversed: true")
        if _angle(drawing.zeros[k]) != "0 deg":
            parts.append(f"offset: {_angle(drawing.zeros[k])}")
        lines.append(f"      {axis}: {{{', '.join(parts)}}}")
    return [*lines, ""]


def _arm(
    drawing: Drawing, ranges: Sequence[tuple[float, float]], rates: Sequence[float]
) -> list[str]:
    hardest = [_HARDER * rate for rate in rates]
    least, time = _FOLLOWING
    behind = max(least, time * max(rates))
    rows = [
        *((key, f"{_number(1e3 * value, 9)} mm") for key, value in drawing.lengths.items()),
        ("wrist_sign", "1"),
        ("position_min", _list([_degrees(low) for low, _ in ranges])),
        ("position_max", _list([_degrees(high) for _, high in ranges])),
        ("rate_limits", _list([f"{_short(rate)} rad/s" for rate in rates])),
        ("acceleration_limits", _list([f"{_short(value)} rad/s^2" for value in hardest])),
    ]
    return [
        "arm:",
        f"  limits: {{acceleration: {_short(min(hardest))} rad/s^2, "
        f"following: {_short(behind)} rad}}",
        "  geometry:",
        *(f"    {key}: {value}" for key, value in rows),
        "",
    ]


def _plant(drawing: Drawing, ranges: Sequence[tuple[float, float]]) -> list[str]:
    elbow = math.atan2(drawing.lengths["elbow_offset"], drawing.lengths["a3"])
    wanted = [*_POSTURE]
    wanted[2] -= elbow
    start = [_within(value, *ends) for value, ends in zip(wanted, ranges, strict=True)]
    reach = drawing.lengths["a2"] + math.hypot(
        drawing.lengths["a3"], drawing.lengths["elbow_offset"]
    )
    larger = max(1.0, (reach / _USUAL.reach) ** 2)
    lines = [
        "plant:  # the simulated arm: masses and drives are estimates",
        f"  start: {_list([_degrees(value) for value in start])}",
    ]
    if larger > 1.0:
        # Inertias, too: drives that bear the stretched arm would shake a folded one without.
        lines += ["  drives:"] + [
            f"    {key}: {_list([f'{_short(larger * value)} {unit}' for value in values])}"
            for key, values, unit in (
                ("torque_limits", _TORQUES, "N m"),
                ("brakes", _BRAKES, "N m"),
                ("inertias", _INERTIAS, "kg m^2"),
            )
        ]
    return lines


def _within(value: float, low: float, high: float) -> float:
    """Return a value or its opposite that is well inside a range, else the range's middle."""
    room = min(0.1, 0.25 * (high - low))
    for candidate in (value, -value):
        if low + room <= candidate <= high - room:
            return candidate
    return 0.5 * (low + high)


def _notes(chain: Chain, off: float) -> list[str]:
    quiet = [joint.name for joint in chain.joints if joint.speed is None]
    endless = [joint.name for joint in chain.joints if _is_endless(joint)]
    near = "within a nanometre of" if off < 1e-9 else f"at most {1e6 * off:.2g} µm from"
    notes = [
        f"in {_POSES} drawn poses the hand is {near} where the description has it",
        f"no description says accelerations: they are {_HARDER:g} per second times the rates",
    ]
    if quiet:
        notes.append(f"no speed is given of {', '.join(quiet)}: the usual 1 or 2 rad/s stand there")
    unranged = [joint.name for joint in chain.joints if not joint.is_ranged]
    if unranged:
        notes.append(
            f"no range is given of {', '.join(unranged)}: 180 deg either way of the laws' zero "
            "stand there; write what its cables bear"
        )
    if endless:
        notes.append(f"{', '.join(endless)} turn without end: two turns are their range")
    return notes


def _angle(value: float) -> str:
    degrees = math.degrees(value)
    rounded = round(degrees, 6) + 0.0
    if abs(degrees - rounded) < 1e-11 * max(abs(degrees), 1.0):
        return f"{_number(rounded, 6)} deg"
    return f"{_number(value, 14)} rad"


def _degrees(value: float) -> str:
    return f"{_number(math.degrees(value), 5)} deg"


def _number(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".")


def _short(value: float) -> str:
    return f"{value:.6g}"


def _list(items: Sequence[str]) -> str:
    return f"[{', '.join(items)}]"


def _one_line(text: str) -> str:
    """Return a name that somebody else chose as it may stand in a comment."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)[:80]
