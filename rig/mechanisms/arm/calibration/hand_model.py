"""Where a marker on the hand is, for many poses at once and with every dimension as a variable."""

from typing import Final, NamedTuple

import numpy as np

from controllers.arm.geometry import ArmGeometry
from rig.calibration.arrays import Array
from rig.mechanisms.arm.settings import HandMetrology

JOINTS: Final = ("q1", "q2", "q3", "q4", "q5", "q6")
LENGTHS: Final = ("a2", "a3", "d6", "base_height", "elbow_offset", "shoulder_offset", "a1")
MARKER: Final = ("marker x", "marker y", "marker z")
FRAME: Final = ("frame roll", "frame pitch", "frame yaw", "frame x", "frame y", "frame z")

_ANGLE, _LENGTH = 0.02, 2e-3
"""By how much such parameters typically are wrong, rad and m."""


class Parameter(NamedTuple):
    """One number that the hand's position depends on.

    Parameters
    ----------
    name : str
        Of `JOINTS` (its zero), `LENGTHS`, `MARKER` or `FRAME`.
    value : float
        What is believed before, rad or m.
    known : float
        Standard uncertainty of that belief; infinite if it is looked for, 0 if it is certain.
    scale : float
        By how much it typically is wrong.
    """

    name: str
    value: float
    known: float
    scale: float

    @property
    def words(self) -> str:
        """How it is called in a sentence."""
        if self.name in JOINTS:
            return f"the zero of {self.name}"
        if self.name in FRAME:
            return f"the instrument's {self.name}"
        return f"the {self.name}" if self.name in MARKER else self.name


def parameters_of(geometry: ArmGeometry, metrology: HandMetrology) -> tuple[Parameter, ...]:
    """Return the parameters of an arm that is measured with an instrument.

    Parameters
    ----------
    geometry : ArmGeometry
        What the profile says.
    metrology : HandMetrology
        How well the marker's place on the hand is known, and whether the instrument's frame is
        the base's.
    """
    frame = np.inf if metrology.frame == "free" else 0.0
    return (
        *(Parameter(name, 0.0, np.inf, _ANGLE) for name in JOINTS),
        *(Parameter(name, getattr(geometry, name), np.inf, _LENGTH) for name in LENGTHS),
        *(
            Parameter(name, value, metrology.marker_accuracy, _LENGTH)
            for name, value in zip(MARKER, geometry.marker, strict=True)
        ),
        *(Parameter(name, 0.0, frame, _ANGLE) for name in FRAME[:3]),
        *(Parameter(name, 0.0, frame, _LENGTH) for name in FRAME[3:]),
    )


def marker_positions(values: Array, readings: Array, wrist_sign: float) -> Array:
    """Return where the instrument sees the marker, m.

    Parameters
    ----------
    values : ndarray, shape (22,)
        Of `parameters_of`, in its order.
    readings : ndarray, shape (n, 6)
        Joints as their drives have them, directions corrected, rad.
    wrist_sign : float
        The geometry's.

    Returns
    -------
    ndarray, shape (n, 3)
    """
    q = readings + values[:6]
    a2, a3, d6, height, elbow, shoulder, a1 = values[6:13]
    x, y, z = values[13:16]
    zeros = np.zeros(len(q))
    # From the marker inwards: tool, wrist, forearm, upper arm, base.
    p = _turn_z(q[:, 5], (zeros + x, zeros + y, zeros + d6 + z))
    p = _turn_z(q[:, 3], _turn_y(wrist_sign * q[:, 4], p))
    p = _turn_y(q[:, 2], (p[0] + elbow, p[1], p[2] + a3))
    p = _turn_y(q[:, 1], (p[0], p[1], p[2] + a2))
    p = _turn_z(q[:, 0], (p[0] + a1, p[1] + shoulder, p[2] + height))
    return np.column_stack(p) @ _rotation(values[16:19]).T + values[19:22]


def align(seen: Array, modelled: Array) -> tuple[Array, Array]:
    """Return rotation and translation that bring modelled points onto seen ones best.

    References
    ----------
    W. Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta
    Crystallographica A32, 1976.
    """
    a, b = modelled - modelled.mean(axis=0), seen - seen.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    mirror = np.diag((1.0, 1.0, np.sign(np.linalg.det(v.T @ u.T))))
    rotation = v.T @ mirror @ u.T
    return rotation, seen.mean(axis=0) - rotation @ modelled.mean(axis=0)


def angles_of(rotation: Array) -> Array:
    """Return roll, pitch and yaw of a rotation, rad: the inverse of what the frame turns by."""
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    pitch = -np.arcsin(np.clip(rotation[2, 0], -1.0, 1.0))
    return np.array((roll, pitch, np.arctan2(rotation[1, 0], rotation[0, 0])))


def _rotation(angles: Array) -> Array:
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
    return np.array(
        (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )
    )


def _turn_y(angle: Array, p: tuple[Array, ...]) -> tuple[Array, ...]:
    c, s = np.cos(angle), np.sin(angle)
    return c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]


def _turn_z(angle: Array, p: tuple[Array, ...]) -> tuple[Array, ...]:
    c, s = np.cos(angle), np.sin(angle)
    return c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]
