"""What a screen shows of an antagonistic pair: two cylinders, and the carriage between them."""

from typing import TYPE_CHECKING

import numpy as np

from rig.hal.scene import Pane, Scene, Shape
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.cylinder.watch import CHANNELS
from rig.mechanisms.outlines import circle, fixed

if TYPE_CHECKING:
    from rig.hal.scene import ColumnOf, Points

_ROUND = 24
_PRESSURES = ("reading.pressure_", "applied.")


class PairScene(Scene):
    """The pair along X: its chambers coloured by pressure, the reference as a ghost.

    The agonist stands at +X and pulls the carriage towards itself.
    """

    def __init__(self, settings: CylinderSettings) -> None:
        self._stroke, self._home = settings.stroke, settings.home
        self._radius = 0.5 * settings.bore
        self._half = 0.25 * settings.stroke
        limits = settings.limits
        self._limits = limits.position
        low, high = limits.pressure
        self.size = 1.06 * (self._half + self._home + settings.stroke)
        self.shapes = (
            Shape("position limits", "line", "limit", 2, 2.0),
            Shape("position limits", "line", "limit", 2, 2.0),
            *(
                shape
                for name in CHANNELS
                for shape in (
                    Shape("cylinder", "loop", "body", _ROUND),
                    Shape("cylinder", "loop", "body", _ROUND),
                    Shape("cylinder", "line", "body", 5),
                    Shape("rod", "line", "part", 2, 4.0),
                    Shape(
                        "piston: pressure", "loop", "tone", _ROUND, 5.0,
                        tone=f"reading.pressure_{name}", tone_range=(low, high),
                    ),
                )
            ),
            Shape("carriage: reference", "loop", "ghost", 4, 3.0),
            Shape("carriage: reading", "loop", "reading", 4, 4.0),
        )  # fmt: skip
        self.panes = (
            Pane("Position", ("reading.position", "reference.position")),
            Pane("Velocity", ("estimate.velocity", "reference.velocity")),
            Pane(
                "Pressures",
                tuple(f"{kind}{name}" for name in CHANNELS for kind in _PRESSURES),
            ),
        )  # fmt: skip
        self.bounds = {
            "reading.position": limits.position,
            "estimate.velocity": (-limits.speed, limits.speed),
            **{f"applied.{name}": limits.pressure for name in CHANNELS},
            "reading.age": (-np.inf, limits.reading_age),
        }

    def place(self, column: "ColumnOf") -> "list[Points]":
        """See `Scene.place`."""
        position = column("reading.position")
        rows = len(position)
        high = 1.6 * self._radius
        posts = [
            fixed([[x, 0.0, -high], [x, 0.0, high]], rows)
            for limit, side in zip(self._limits, (-1.0, 1.0), strict=True)
            for x in (limit + side * self._half,)
        ]
        agonist = self._cylinder(column("reading.position_agonist"), position, 1.0)
        antagonist = self._cylinder(column("reading.position_antagonist"), position, -1.0)
        wanted, seen = self._carriage(column("reference.position")), self._carriage(position)
        return [*posts, *agonist, *antagonist, wanted, seen]

    def _cylinder(
        self, extension: "Points", position: "Points", side: float
    ) -> "tuple[Points, ...]":
        """Return both ends, the walls, the rod and the piston of a cylinder that does not move."""
        rows = len(position)
        near = side * (self._half + self._home)  # where the rod comes out
        far = near + side * self._stroke
        round_ = circle(self._radius, _ROUND, axis=0)
        ends = [fixed(round_ + np.array([x, 0.0, 0.0]), rows) for x in (near, far)]
        r = self._radius
        walls = fixed([[near, 0, r], [far, 0, r], [far, 0, -r], [near, 0, -r], [near, 0, r]], rows)
        piston = near + side * (self._stroke - extension)
        tip = position + side * self._half
        rod = np.zeros((rows, 2, 3))
        rod[:, 0, 0], rod[:, 1, 0] = piston, tip
        disc = np.tile(round_ * 0.9, (rows, 1, 1))
        disc[:, :, 0] = piston[:, None]
        return (*ends, walls, rod, disc)

    def _carriage(self, position: "Points") -> "Points":
        half, high = self._half, self._radius
        corners = np.array([[-half, 0, -high], [half, 0, -high], [half, 0, high], [-half, 0, high]])
        placed = np.tile(corners, (len(position), 1, 1))
        placed[:, :, 0] += position[:, None]
        return placed
