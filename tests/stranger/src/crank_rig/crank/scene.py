"""What a screen shows of the cranks: two wheels, and the rod between them."""

from typing import TYPE_CHECKING

import numpy as np

from crank_rig.crank.settings import CrankSettings
from crank_rig.crank.types import AXES
from rig.hal.scene import Pane, Scene, Shape, beside_reference

if TYPE_CHECKING:
    from rig.hal.scene import ColumnOf, Points

_APART, _RADIUS = 0.3, 0.1


class CrankScene(Scene):
    """Both cranks from the front; the rod leads from one pin to the other."""

    def __init__(self, settings: CrankSettings) -> None:
        self.size = _APART
        self.shapes = (
            *(Shape(f"{name} crank", "line", "body", 2, 6.0) for name in AXES),
            Shape("rod", "line", "part", 2, 3.0),
            Shape("pins", "dot", "reading", 2, 9.0, trail=2.0),
        )
        self.panes = (
            Pane("Cranks", beside_reference(f"position_{name}" for name in AXES)),
            Pane("Twist", ("reading.twist",)),
        )
        self.bounds = {"reading.twist": (-settings.max_twist, settings.max_twist)}

    def place(self, column: "ColumnOf") -> "list[Points]":
        """See `Scene.place`."""
        cranks = []
        for name, x in zip(AXES, (-0.5 * _APART, 0.5 * _APART), strict=True):
            angle = column(f"reading.position_{name}")
            hub = np.broadcast_to([x, 0.0, 0.0], (len(angle), 3))
            arm = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
            cranks.append(np.stack([hub, hub + _RADIUS * arm], axis=1))
        pins = np.stack([crank[:, 1] for crank in cranks], axis=1)
        return [*cranks, pins, pins]
