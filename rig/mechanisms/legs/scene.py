"""What a screen shows of the legs: their links, what they stand on, and what has to be above it."""

from typing import TYPE_CHECKING

import numpy as np

from controllers.gait.geometry import AXIS_NAMES, JOINTS, KNEES, LEGS
from rig.hal.scene import Pane, Scene, Shape, beside_reference
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.outlines import track

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.hal.scene import ColumnOf, Points

_TRAIL = 20.0
_CORNERS = 8
"""Points of the support polygon: two soles have so many corners, and some may stand twice."""


class LegsScene(Scene):
    """Both legs from their measured joints, on the planned footprint of the one that stands.

    There is no measurement of where the robot is: a planned sole that stands is taken to lie where
    and as it was planned.
    """

    follows = "waist"

    def __init__(self, settings: LegsSettings) -> None:
        its = self._its = settings.geometry
        height = its.reach + its.ankle_height
        self.size = 0.74 * height
        self.centre = (0.0, 0.0, 0.46 * height)
        self.shapes = (
            Shape("support polygon", "loop", "limit", _CORNERS, 2.5),
            Shape("soles", "loop", "ground", 4, 2.0),
            Shape("soles", "loop", "ground", 4, 2.0),
            Shape(f"{LEGS[0]} leg", "line", "body", 6, 11.0),
            Shape(f"{LEGS[1]} leg", "line", "part", 6, 11.0),
            Shape("joints", "dot", "part", 6, 13.0),
            Shape("centre of mass, on the ground", "dot", "reading", 1, 13.0, trail=_TRAIL),
            Shape("zero-moment point", "dot", "reference", 1, 8.0, trail=_TRAIL),
            Shape("waist", "dot", "body", 1, 9.0),
        )  # fmt: skip
        self.panes = (
            Pane("Inside the support polygon", ("plan.static_margin", "plan.margin")),
            Pane("Knees", beside_reference(f"position_{AXIS_NAMES[k]}" for k in KNEES)),
            Pane("Right leg", tuple(f"reading.position_right_{joint}" for joint in JOINTS)),
            Pane("Left leg", tuple(f"reading.position_left_{joint}" for joint in JOINTS)),
        )  # fmt: skip
        self.bounds = {
            "plan.margin": (settings.balance.min_margin, np.inf),
            **{
                f"reading.position_{name}": bound
                for name, bound in zip(AXIS_NAMES, its.limits, strict=True)
            },
            **{f"reading.velocity_{name}": (-its.max_rate, its.max_rate) for name in AXIS_NAMES},
            "reading.age": (-np.inf, settings.limits.reading_age),
        }

    def place(self, column: "ColumnOf") -> "list[Points]":
        """See `Scene.place`."""
        prints = [
            track(*(column(f"reference.{leg}_foot_{axis}") for axis in "xyz"))[:, 0] for leg in LEGS
        ]
        chains = [self._leg(column, number) for number in range(len(LEGS))]
        # Seen from the waist, and so turned and moved by what the foot that stands is known to be.
        stand = [column(f"plan.stands_{leg}") > 0.0 for leg in LEGS]
        left = stand[1] & ~stand[0]
        lies = [
            _about(2, column(f"reference.{leg}_foot_yaw"))
            @ _about(1, column(f"reference.{leg}_foot_pitch"))
            @ _about(0, column(f"reference.{leg}_foot_roll"))
            for leg in LEGS
        ]
        standing = np.where(
            left[:, None, None],
            chains[1][1] @ np.swapaxes(lies[1], 1, 2),
            chains[0][1] @ np.swapaxes(lies[0], 1, 2),
        )
        sole = np.where(left[:, None], chains[1][0][:, -1], chains[0][0][:, -1])
        printed = np.where(left[:, None], prints[1], prints[0])
        legs = [
            np.einsum("nji,npj->npi", standing, points - sole[:, None]) + printed[:, None]
            for points, _ in chains
        ]
        soles = [
            np.einsum("nji,njk,pk->npi", standing, rotation, self._sole()) + points[:, -1:]
            for points, (_, rotation) in zip(legs, chains, strict=True)
        ]
        support = _around(soles, stand)
        ground = np.zeros(len(left))
        mass, moment = (
            track(column(f"{name}_x"), column(f"{name}_y"), ground)
            for name in ("plan.mass", "plan.zero_moment")
        )
        joints = np.concatenate([points[:, 1:4] for points in legs], axis=1)
        return [support, *soles, *legs, joints, mass, moment, legs[0][:, :1]]

    def _sole(self) -> "Points":
        sole = self._its.sole
        x, y = (sole.front, sole.front, -sole.back, -sole.back), sole.half_width
        return np.stack([x, [y, -y, -y, y], np.zeros(4)], axis=1)

    def _leg(self, column: "ColumnOf", leg: int) -> "tuple[Points, Points]":
        """Return waist, hip, knee, ankle, ankle and sole from the waist, m, and the foot's axes."""
        its = self._its
        yaw, roll, pitch, knee, ankle, foot = (
            column(f"reading.position_{LEGS[leg]}_{joint}") for joint in JOINTS
        )
        hip = _about(2, yaw) @ _about(0, roll)
        thigh = hip @ _about(1, pitch)
        shank = hip @ _about(1, pitch + knee)
        last = hip @ _about(1, pitch + knee + ankle) @ _about(0, foot)
        rows = len(yaw)
        points = np.zeros((rows, 6, 3))
        points[:, 1] = (0.0, its.side(leg), 0.0)
        points[:, 2] = points[:, 1] - its.thigh * thigh[:, :, 2]
        points[:, 3] = points[:, 2] - its.shank * shank[:, :, 2]
        points[:, 4] = points[:, 3]
        points[:, 5] = points[:, 3] - its.ankle_height * last[:, :, 2]
        return points, last


def _about(axis: int, angle: "Points") -> "Points":
    """Return rotations about a coordinate axis, shape (n, 3, 3)."""
    turned = np.zeros((len(angle), 3, 3))
    one, two = (axis + 1) % 3, (axis + 2) % 3
    turned[:, axis, axis] = 1.0
    turned[:, one, one] = turned[:, two, two] = np.cos(angle)
    turned[:, two, one] = np.sin(angle)
    turned[:, one, two] = -np.sin(angle)
    return turned


def _around(soles: "list[Points]", standing: "list[NDArray[np.bool_]]") -> "Points":
    """Return the corners of the hull of the soles that stand, on the ground, `_CORNERS` each."""
    hulls = np.zeros((len(soles[0]), _CORNERS, 3))
    stands = np.stack(standing, axis=1)
    for row in range(len(hulls)):
        corners = [
            (float(x), float(y))
            for sole, stand in zip(soles, stands[row], strict=True)
            if stand or not stands[row].any()
            for x, y, _ in sole[row]
        ]
        hull = _hull(corners)
        hull += [hull[-1]] * (_CORNERS - len(hull))
        hulls[row, :, :2] = hull
        heights = np.array([sole[row, :, 2].mean() for sole in soles])
        if stands[row].any():
            hulls[row, :, 2] = heights[stands[row]].mean()
    return hulls


def _hull(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the convex hull of points, counter-clockwise.

    References
    ----------
    A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information
    Processing Letters 9 (5), 1979.
    """
    ordered = sorted(set(points))
    halves = []
    for run in (ordered, ordered[::-1]):
        half: list[tuple[float, float]] = []
        for x, y in run:
            while len(half) > 1:
                (ax, ay), (bx, by) = half[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                half.pop()
            half.append((x, y))
        halves += half[:-1]
    return halves or ordered
