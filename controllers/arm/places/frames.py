"""Frames that places are seen in: of the base, of the hand at the start, or taught at a fixture."""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Unit

from controllers.arm.types import Rotation, Vector
from controllers.arm.vectors import dot, minus, scaled
from controllers.motion import InfeasibleMotion

Length = Annotated[float, Unit("m")]
Angle = Annotated[float, Unit("rad")]
Place = tuple[Length, Length, Length]

_NEAREST = 1e-3
"""Of a taught point from the origin, or from the X axis: nearer ones do not say a direction, m."""


@dataclass(frozen=True, slots=True)
class TaughtFrame:
    """A frame by its origin and rotation, or by three points that the hand was led to.

    Parameters
    ----------
    origin : tuple of float
        In the base's axes, m.
    rotation : tuple of float
        Rotation vector from the base's axes to the frame's: axis times angle, rad.
    on_x : tuple of float, optional
        Instead of a rotation: a point on the frame's positive X axis, in the base's axes, m.
    in_xy : tuple of float, optional
        With `on_x`: a point of the frame's XY plane on the side of its positive Y axis, m.

    Raises
    ------
    ValueError
        Points and a rotation are given, one point alone, or points so near to each other, or so
        near to one line, that they say no direction.
    """

    origin: Place = (0.0, 0.0, 0.0)
    rotation: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    on_x: Place | None = None
    in_xy: Place | None = None

    def __post_init__(self) -> None:
        if (self.on_x is None) != (self.in_xy is None):
            raise ValueError("on_x and in_xy belong together: give both of them, or a rotation.")
        if self.on_x is not None and any(self.rotation):
            raise ValueError("give a rotation or the points on_x and in_xy, and not both.")
        self.axes  # noqa: B018  (raises where the points say none)

    @property
    def axes(self) -> Rotation:
        """The rotation matrix, base from frame."""
        if self.on_x is None or self.in_xy is None:
            return _of_vector(self.rotation)
        along, aside = minus(self.on_x, self.origin), minus(self.in_xy, self.origin)
        length = math.hypot(*along)
        if not length >= _NEAREST:
            raise ValueError(
                f"on_x is {1e3 * length:.4g} mm from the origin; it must be {1e3 * _NEAREST:g} mm "
                f"from it at least to say where X points."
            )
        x = scaled(along, 1.0 / length)
        across = minus(aside, scaled(x, dot(aside, x)))
        off = math.hypot(*across)
        if not off >= _NEAREST:
            raise ValueError(
                f"in_xy is {1e3 * off:.4g} mm from the line through the origin and on_x; it "
                f"must be {1e3 * _NEAREST:g} mm from it at least to say where Y points."
            )
        y = scaled(across, 1.0 / off)
        z = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
        return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


def frame_called(name: str, frames: Mapping[str, TaughtFrame]) -> TaughtFrame:
    """Return a rig's frame.

    Raises
    ------
    InfeasibleMotion
        It has none of that name.
    """
    if name in frames:
        return frames[name]
    near = difflib.get_close_matches(name, ["base", "start", *frames], 1)
    hint = f"; did you mean {near[0]}?" if near else "."
    raise InfeasibleMotion(
        f"no frame is called {name!r}; there are base, start and of the rig "
        f"{', '.join(frames) or 'none'}{hint}"
    )


def _of_vector(vector: Vector) -> Rotation:
    """Return the rotation matrix of a rotation vector, rad."""
    angle = math.hypot(*vector)
    x, y, z = scaled(vector, 1.0 / angle) if angle else (0.0, 0.0, 1.0)
    s, c = math.sin(angle), math.cos(angle)
    v = 1.0 - c
    return (
        (c + v * x * x, v * x * y - s * z, v * x * z + s * y),
        (v * x * y + s * z, c + v * y * y, v * y * z - s * x),
        (v * x * z - s * y, v * y * z + s * x, c + v * z * z),
    )
