"""What a screen shows of the arm: its links, the hand's path, and the pose that is wanted."""

import math
from typing import TYPE_CHECKING

import numpy as np

from controllers.arm.geometry import AXIS_NAMES, ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward, link_points
from rig.hal.scene import Pane, Scene, Shape
from rig.mechanisms.arm.boundary import meridian
from rig.mechanisms.arm.settings import ArmSettings
from rig.mechanisms.outlines import circle, fixed, track

if TYPE_CHECKING:
    from rig.hal.scene import ColumnOf, Points

_ROUND = 64
_TRAIL = 30.0
_TOOL = 0.06
"""Length of the tool's axes as they are drawn, m."""


class ArmScene(Scene):
    """Links and hand, the wanted pose as a ghost, and the edge of the workspace.

    On that edge the elbow is straight: the singular region of the elbow lies along it. That of
    the shoulder is the vertical through its foot.
    """

    def __init__(self, settings: ArmSettings) -> None:
        its = settings.geometry
        self._arm = dimensions_of(its)
        self._reach, self._height = its.reach, its.base_height
        self._edges = _edges(its)
        self.size = 1.06 * (its.reach + abs(its.a1))  # the whole edge of the workspace
        self.centre = (0.0, 0.0, its.base_height)
        self.shapes = (
            Shape("ground", "loop", "ground", _ROUND, 1.0),
            *(Shape("singular: elbow", "loop", "limit", _ROUND, 1.0) for _ in range(3)),
            Shape("singular: shoulder", "line", "limit", 2, 1.0),
            Shape("wanted pose", "line", "ghost", 5, 5.0),
            Shape("links", "line", "body", 5, 7.0),
            Shape("joints", "dot", "part", 3, 11.0),
            *(Shape("tool", "line", "part", 2, 2.0) for _ in range(3)),
            Shape("hand: path", "dot", "reference", 1, 6.0, trail=_TRAIL),
            Shape("hand: reading", "dot", "reading", 1, 9.0, trail=_TRAIL),
        )
        self.panes = (
            Pane(
                "Singular at 0: elbow, wrist",
                (
                    "reading.index_elbow",
                    "plan.index_elbow",
                    "reading.index_wrist",
                    "plan.index_wrist",
                ),
            ),
            Pane("Joints", tuple(f"reading.position_{name}" for name in AXIS_NAMES)),
            Pane("Joint velocities", tuple(f"reading.velocity_{name}" for name in AXIS_NAMES)),
            Pane("Hand", tuple(f"reading.hand_{axis}" for axis in "xyz")),
        )
        rates = zip(AXIS_NAMES, its.rate_limits, strict=True)
        ranges = zip(AXIS_NAMES, its.position_min, its.position_max, strict=True)
        self.bounds = {
            **{f"reading.position_{name}": (low, high) for name, low, high in ranges},
            **{f"reading.velocity_{name}": (-most, most) for name, most in rates},
            "reading.age": (-np.inf, settings.limits.reading_age),
        }

    def place(self, column: "ColumnOf") -> "list[Points]":
        """See `Scene.place`."""
        arm = self._arm
        seen, wanted = (
            np.column_stack([column(f"{kind}.position_{name}") for name in AXIS_NAMES]).tolist()
            for kind in ("reading", "reference")
        )
        rows = len(seen)
        links = np.array([link_points(arm, tuple(q)) for q in seen]).reshape(rows, 5, 3)
        ghost = np.array([link_points(arm, tuple(q)) for q in wanted]).reshape(rows, 5, 3)
        axes = np.array([forward(arm, tuple(q)).rotation for q in seen]).reshape(rows, 3, 3)
        hand = links[:, 4:]
        tools = [
            np.concatenate([hand, hand + _TOOL * axis[:, None]], axis=1)
            for axis in axes.transpose(1, 0, 2)
        ]
        shoulder = np.array([0.0, 0.0, self._height])
        edge = [fixed(points, rows) for points in self._edges]
        return [
            fixed(circle(0.25 * self._reach, _ROUND), rows),
            *edge,
            fixed(np.outer([0.0, self._reach], [0.0, 0.0, 1.0]) + shoulder, rows),
            ghost,
            links,
            links[:, 1:4],
            *tools,
            track(*(column(f"plan.path_{axis}") for axis in "xyz")),
            track(*(column(f"reading.hand_{axis}") for axis in "xyz")),
        ]


def _edges(geometry: ArmGeometry) -> "tuple[Points, ...]":
    """Return three outlines of the wrist's reach: two upright, one level."""
    reach, a1, offset = geometry.reach, abs(geometry.a1), geometry.shoulder_offset
    away, height = meridian(reach, a1, offset, _ROUND).T
    height = height + geometry.base_height
    level = circle(math.hypot(reach + a1, offset), _ROUND)
    none = np.zeros(_ROUND)
    return (
        np.column_stack((none, away, height)),
        np.column_stack((away, none, height)),
        level + np.array((0.0, 0.0, geometry.base_height)),
    )
