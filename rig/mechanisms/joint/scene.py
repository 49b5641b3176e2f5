"""What a screen shows of the spherical joint: ball, ring, wires and marker."""

import math
from typing import TYPE_CHECKING

import numpy as np

from rig.hal.scene import Pane, Scene, Shape, beside_reference
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.outlines import circle, fixed, track

if TYPE_CHECKING:
    from rig.hal.scene import ColumnOf, Points

_ROUND, _ARC = 48, 12
_TRAIL = 12.0


class JointScene(Scene):
    """The ball with the ring on it, the wires coloured by tension, and the marker's way.

    The ring stands as the encoders see the marker; its spin, which they do not see, is left out.
    """

    def __init__(self, settings: JointSettings) -> None:
        its = self._its = settings.geometry
        limits = settings.limits
        self._tilt = limits.tilt
        self.size = 1.02 * its.marker_height
        self.centre = (0.0, 0.0, 0.25 * its.marker_height)
        self._below = -1.4 * its.adjust_depth
        pressure = tuple(f"reading.pressure_{name}" for name in CHANNELS)
        self.shapes = (
            Shape("ball", "dot", "body", 1, radius=its.ball_radius),
            Shape("greatest tilt", "loop", "limit", _ROUND, 1.5),
            Shape("ring", "loop", "part", _ROUND, 4.0),
            *(
                Shape(
                    "wires: tension", "line", "tone", _ARC + 2, 3.0,
                    tone=f"estimate.tension_{name}", tone_range=limits.tension,
                )
                for name in CHANNELS
            ),
            Shape("stem", "line", "part", 2, 3.0),
            Shape("marker: reference", "dot", "reference", 1, 9.0, trail=_TRAIL),
            Shape("marker: reading", "dot", "reading", 1, 11.0, trail=_TRAIL),
        )  # fmt: skip
        self.panes = (
            Pane("Marker x", ("estimate.marker_x", "reference.marker_x")),
            Pane("Marker y", ("estimate.marker_y", "reference.marker_y")),
            Pane("Rods", beside_reference(f"rod_{name}" for name in CHANNELS)),
            Pane("Tensions", tuple(f"estimate.tension_{name}" for name in CHANNELS)),
            Pane("Pressures", pressure),
        )  # fmt: skip
        self.bounds = {
            **{f"applied.{name}": limits.pressure for name in CHANNELS},
            **{f"estimate.tension_{name}": limits.tension for name in CHANNELS},
            "estimate.residual": (-limits.residual, limits.residual),
            "reading.age": (-np.inf, limits.reading_age),
        }

    def place(self, column: "ColumnOf") -> "list[Points]":
        """See `Scene.place`."""
        its = self._its
        marker, wanted = (
            track(*(column(f"{name}_{axis}") for axis in "xyz"))
            for name in ("estimate.encoder_marker", "reference.marker")
        )
        rows = len(marker)
        axis = marker[:, 0] / np.linalg.norm(marker[:, 0], axis=1, keepdims=True).clip(1e-9)
        turn = _from_vertical(axis)
        ball = fixed(np.zeros((1, 3)), rows)
        lean = its.marker_height * np.array([math.sin(self._tilt), math.cos(self._tilt)])
        edge = fixed(circle(lean[0], _ROUND) + np.array([0.0, 0.0, lean[1]]), rows)
        ring = (circle(its.ring_radius, _ROUND) + np.array([0.0, 0.0, its.ring_height])) @ turn
        wires = [
            self._wire(np.asarray(anchor) @ turn, np.asarray(adjust))
            for anchor, adjust in zip(its.anchors, its.adjust_points, strict=True)
        ]
        seat = axis[:, None] * its.ball_radius
        stem = np.concatenate([seat, axis[:, None] * its.marker_height], axis=1)
        return [ball, edge, ring, *wires, stem, wanted, marker]

    def _wire(self, anchor: "Points", adjust: "Points") -> "Points":
        """Return a wire: on the ball as far as it lies on it, then straight to where it leaves.

        Parameters
        ----------
        anchor : ndarray, shape (n, 3)
            On the ring, m.
        adjust : ndarray, shape (3,)
            Where the wire leaves the joint, m.
        """
        radius = self._its.ball_radius
        out, end = anchor / radius, adjust / np.linalg.norm(adjust)
        between = np.arccos(np.clip(out @ end, -1.0, 1.0))
        free = math.acos(min(radius / float(np.linalg.norm(adjust)), 1.0))
        across = end - out * np.cos(between)[:, None]
        across /= np.linalg.norm(across, axis=1, keepdims=True).clip(1e-9)
        lies = np.maximum(between - free, 0.0)[:, None] * np.linspace(0.0, 1.0, _ARC)
        arc = radius * (
            np.cos(lies)[..., None] * out[:, None] + np.sin(lies)[..., None] * across[:, None]
        )
        down = np.array([adjust[0], adjust[1], self._below])
        ends = np.broadcast_to([adjust, down], (len(anchor), 2, 3))
        return np.concatenate([arc, ends], axis=1)


def _from_vertical(axis: "Points") -> "Points":
    """Return what turns row vectors about the least angle from the vertical, shape (n, 3, 3)."""
    x, y, z = axis.T
    k = 1.0 / np.maximum(1.0 + z, 1e-9)
    rows = [[1 - k * x * x, -k * x * y, x], [-k * x * y, 1 - k * y * y, y], [-x, -y, z]]
    return np.array(rows).transpose(2, 1, 0)
