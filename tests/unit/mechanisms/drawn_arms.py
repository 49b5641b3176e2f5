"""URDFs of arms whose every joint is known: dimensions, senses, zeros and frames are drawn."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation as Turn

LENGTHS = ("a1", "a2", "a3", "d6", "base_height", "elbow_offset", "shoulder_offset")


class DrawnArm(NamedTuple):
    """An arm at its own zero: axes, points on them, the tool; base axes, m."""

    axes: list
    points: list
    position: np.ndarray
    rotation: np.ndarray


def draw_lengths(rng):
    """Return the lengths of an arm of the covered family, some of which may be absent."""
    offsets = rng.uniform(-0.15, 0.15, 3) * rng.choice((0.0, 1.0), 3)
    return {
        "a1": abs(offsets[0]),
        "a2": rng.uniform(0.2, 0.6),
        "a3": rng.uniform(0.2, 0.6),
        "d6": rng.uniform(0.02, 0.2),
        "base_height": rng.uniform(0.0, 0.6),
        "elbow_offset": offsets[1],
        "shoulder_offset": offsets[2],
    }


def draw_arm(rng, lengths, angles):
    """Return an arm whose zero is the laws' posture `angles`, link by link."""
    g = lengths
    turn, at = Turn.identity(), np.array((0.0, 0.0, g["base_height"]))
    axes, points = [], []
    links = (
        ("z", (g["a1"], g["shoulder_offset"], 0.0)),
        ("y", (0.0, 0.0, g["a2"])),
        ("y", (g["elbow_offset"], 0.0, g["a3"])),
        ("z", (0.0, 0.0, 0.0)),
        ("y", (0.0, 0.0, 0.0)),
        ("z", (0.0, 0.0, g["d6"])),
    )
    for (axis, link), angle in zip(links, angles, strict=True):
        sense = rng.choice((-1.0, 1.0))
        direction = turn.apply(np.eye(3)["xyz".index(axis)])
        axes.append(sense * direction)
        points.append(at + rng.uniform(-0.3, 0.3) * direction)
        turn = turn * Turn.from_euler(axis, angle)
        at = at + turn.apply(link)
    return DrawnArm(axes, points, at, (turn * Turn.random(rng=rng)).as_matrix())


def urdf_of(arm, rng, ranges=None, extra=""):
    """Return a URDF in which every link's frame stands as drawn."""
    rows = ['<?xml version="1.0"?>', '<robot name="drawn">', '<link name="root"/>', extra]
    before, parent = np.eye(4), "root"
    for k, (axis, point) in enumerate(zip(arm.axes, arm.points, strict=True)):
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = Turn.random(rng=rng).as_matrix(), point
        low, high = (-3.0, 3.0) if ranges is None else ranges[k]
        rows += _joint(f"axis {k + 1}", parent, f"link {k + 1}", np.linalg.inv(before) @ frame)
        x, y, z = (frame[:3, :3].T @ axis).tolist()
        rows.insert(-1, f'<axis xyz="{x!r} {y!r} {z!r}"/>')
        rows.insert(-1, f'<limit lower="{low}" upper="{high}" velocity="2.5" effort="40"/>')
        before, parent = frame, f"link {k + 1}"
    tool = np.eye(4)
    tool[:3, :3], tool[:3, 3] = arm.rotation, arm.position
    rows += _joint("flange", parent, "tool", np.linalg.inv(before) @ tool, "fixed")
    return "\n".join([*rows, "</robot>"])


def _joint(name, parent, child, placed, kind="revolute"):
    x, y, z = placed[:3, 3].tolist()
    roll, pitch, yaw = Turn.from_matrix(placed[:3, :3]).as_euler("xyz").tolist()
    return [
        f'<link name="{child}"/>',
        f'<joint name="{name}" type="{kind}">',
        f'<origin xyz="{x!r} {y!r} {z!r}" rpy="{roll!r} {pitch!r} {yaw!r}"/>',
        f'<parent link="{parent}"/><child link="{child}"/>',
        "</joint>",
    ]


def posture_of(arm, angles):
    """Return where the tool is for joint angles (rad), turn by turn from the last joint."""
    position, rotation = np.array(arm.position), Turn.from_matrix(arm.rotation)
    for axis, point, angle in zip(arm.axes[::-1], arm.points[::-1], angles[::-1], strict=True):
        turn = Turn.from_rotvec(angle * axis)
        position, rotation = point + turn.apply(position - point), turn * rotation
    return position, rotation.as_matrix()


def away(one, other):
    """Return how far poses are apart, in m and as matrices."""
    return max(float(np.abs(np.subtract(a, b)).max()) for a, b in zip(one, other, strict=True))


def universal_robot():
    """Return an arm like a UR5: its wrist's axes do not meet in one point."""
    x, y, z = np.eye(3)
    return DrawnArm(
        [z, y, y, y, -z, y],
        [
            0.0 * x,
            0.089159 * z,
            0.089159 * z - 0.425 * x,
            0.089159 * z - 0.81725 * x,
            0.089159 * z - 0.81725 * x + 0.10915 * y,
            -0.005491 * z - 0.81725 * x,
        ],
        -0.005491 * z - 0.81725 * x + 0.19145 * y,
        np.eye(3),
    )
