"""How the tool turns along a spline of places: from rotations, or from directions alone."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation as Turn
from scipy.spatial.transform import RotationSpline

from controllers.arm.places.poses import Quaternion
from controllers.arm.types import Vector
from controllers.motion import InfeasibleMotion

Array = NDArray[np.float64]

_STEPS = 4000
"""Over which the tool is carried along its directions; what one misses is the third power of it."""
_WIDEST = math.radians(150.0)
"""Between two directions; further apart, the way from one to the other is anybody's guess."""
_SMALL = 1e-6
"""Square of an angle below which two terms of its series do, rad²."""
_OPPOSITE = 1e-9
"""1 + cosine of directions that no least rotation leads from one to the other."""


class ToolTurning(Protocol):
    """The tool's rotation along a spline, over the spline's parameter."""

    def at(self, u: float) -> Array:
        """Return the rotation matrix, shape (3, 3)."""

    def rate(self, u: float) -> Array:
        """Return the angular velocity over the parameter, base axes, shape (3,)."""


class Constant:
    """A tool that keeps its direction: rotation, shape (3, 3)."""

    def __init__(self, tool: Array) -> None:
        self._tool = tool

    def at(self, u: float) -> Array:
        """Return the rotation matrix."""
        del u
        return self._tool

    def rate(self, u: float) -> Array:
        """Return none."""
        del u
        return np.zeros(3)


class Splined:
    """A spline through rotations at given parameters; `before` turns them all."""

    def __init__(self, u: Array, quaternions: Sequence[Quaternion], before: Array) -> None:
        turns = Turn.from_quat(np.roll(np.array(quaternions), -1, axis=1))
        self._spline = RotationSpline(u, Turn.from_matrix(before) * turns)
        # Asked for thousands of times, one by one: scipy takes 400 us for each.
        self._knots: list[float] = u.tolist()
        self._rotations = self._spline.rotations.as_matrix()
        self._vectors: list[list[list[float]]] = np.moveaxis(
            self._spline.interpolator.c, 0, 2
        ).tolist()

    def at(self, u: float) -> Array:
        """Return the rotation matrix."""
        k = min(max(bisect_right(self._knots, u) - 1, 0), len(self._vectors) - 1)
        s = u - self._knots[k]
        x, y, z = (((a * s + b) * s + c) * s + d for a, b, c, d in self._vectors[k])
        return np.asarray(self._rotations[k] @ _turn(x, y, z))

    def rate(self, u: float) -> Array:
        """Return the angular velocity; a spline of rotations has it in the tool's axes."""
        return np.asarray(self._spline(u).apply(self._spline(u, 1)))


class Pointed:
    """A tool whose direction is a spline: it turns about it no more than it is told.

    Without a spin it is carried along without turning about its own axis. It begins as near as
    it can to the rotation that is given.

    Parameters
    ----------
    u : ndarray, shape (n,)
        Parameters of the directions.
    directions : sequence of tuple of float
        Unit vectors along the tool, base axes.
    spins : sequence of float, optional
        Of the tool about its direction, beyond where it is carried to, rad.
    tool : ndarray, shape (3, 3)
        How the tool stands that is turned into the first direction.

    Raises
    ------
    InfeasibleMotion
        Two directions are nearly opposite.

    References
    ----------
    W. Wang, B. Jüttler, D. Zheng and Y. Liu, "Computation of Rotation Minimizing Frames", ACM
    Transactions on Graphics 27(1), 2008.
    """

    def __init__(
        self, u: Array, directions: Sequence[Vector], spins: Sequence[float] | None, tool: Array
    ) -> None:
        given = np.array(directions)
        between = np.arccos(np.clip(np.einsum("ij,ij->i", given[1:], given[:-1]), -1.0, 1.0))
        if between.max() > _WIDEST:
            k = int(np.argmax(between))
            raise InfeasibleMotion(
                f"the tool turns by {math.degrees(between[k]):.1f} deg from place {k + 1} to place "
                f"{k + 2}; beyond {math.degrees(_WIDEST):g} deg its way there is not known: give "
                f"one between."
            )
        self._vectors = CubicSpline(u, given)
        self._spins = None if spins is None else CubicSpline(u, np.array(spins))
        self._u = np.unique(np.concatenate((np.linspace(u[0], u[-1], _STEPS), u)))
        along = self._vectors(self._u)
        lengths = np.linalg.norm(along, axis=1)
        if lengths.min() < 0.1:
            k = int(np.searchsorted(u, self._u[int(np.argmin(lengths))], side="right"))
            raise InfeasibleMotion(
                f"the tool's directions about place {min(k, len(u) - 1)} swing too far for a "
                f"spline; give one between."
            )
        self._along: Array = along / lengths[:, None]
        self._across = self._carried(_least_rotation(tool[:, 2], self._along[0]) @ tool[:, 0])

    def at(self, u: float) -> Array:
        """Return the rotation matrix."""
        k = int(np.clip(np.searchsorted(self._u, u, side="right") - 1, 0, len(self._u) - 1))
        vector = self._vectors(u)
        z = vector / math.sqrt(vector @ vector)
        x = _carry(self._across[k], self._along[k], z)
        y = _cross(z, x)
        if self._spins is not None:
            spin = float(self._spins(u))
            x = math.cos(spin) * x + math.sin(spin) * y
            y = _cross(z, x)
        return np.column_stack((x, y, z))

    def rate(self, u: float) -> Array:
        """Return the angular velocity."""
        vector, slope = self._vectors(u), self._vectors(u, 1)
        turned = _cross(vector, slope) / (vector @ vector)
        if self._spins is not None:
            turned = turned + float(self._spins(u, 1)) * vector / math.sqrt(vector @ vector)
        return np.asarray(turned)

    def _carried(self, first: Array) -> Array:
        """Return the tool's X axis along the directions, carried from step to step."""
        rows = [first - (first @ self._along[0]) * self._along[0]]
        for before, after in zip(self._along[:-1], self._along[1:], strict=True):
            rows.append(_carry(rows[-1], before, after))
        across = np.array(rows)
        return np.asarray(across / np.linalg.norm(across, axis=1)[:, None])


def _turn(x: float, y: float, z: float) -> Array:
    """Return the rotation matrix of a rotation vector, rad."""
    square = x * x + y * y + z * z
    if square < _SMALL:
        sine, cosine = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        angle = math.sqrt(square)
        sine, cosine = math.sin(angle) / angle, 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    a, b, c = cosine * x * y, cosine * x * z, cosine * y * z
    x, y, z, xx, yy, zz = sine * x, sine * y, sine * z, x * x, y * y, z * z
    return np.array(
        (
            (1.0 - cosine * (yy + zz), a - z, b + y),
            (a + z, 1.0 - cosine * (xx + zz), c - x),
            (b - y, c + x, 1.0 - cosine * (xx + yy)),
        )
    )


def _carry(x: Array, before: Array, after: Array) -> Array:
    """Return a vector across a direction, turned with it in the least way."""
    return np.asarray(x - (after @ x) / (1.0 + before @ after) * (before + after))


def _cross(a: Array, b: Array) -> Array:
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0))


def _least_rotation(before: Array, after: Array) -> Array:
    """Return the least rotation of one direction into another; opposite, about any axis across."""
    if 1.0 + float(before @ after) < _OPPOSITE:
        across = np.eye(3)[int(np.argmin(np.abs(before)))]
        axis = _cross(before, across)
        axis /= math.sqrt(axis @ axis)
        return np.asarray(2.0 * np.outer(axis, axis) - np.eye(3))
    axis = _cross(before, after)
    skew = np.cross(np.eye(3), axis)
    return np.asarray(np.eye(3) + skew + skew @ skew / (1.0 + before @ after))
