"""Where a motion goes through or past singularities, and what the joints do there."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arm.geometry import AXIS_NAMES

Array = NDArray[np.float64]

NEAR = (0.03, 0.05, 0.05)
"""Below these c (m), S3 and S5 a motion is near the shoulder's, elbow's, wrist's singularity."""
_KINDS = ("shoulder", "elbow", "wrist")
_SWINGS = ((0,), (2,), (3, 5))
"""Joints that move fast next to it."""


_ROUND = math.radians(150.0)
"""rad: a joint that swings farther turns round."""
_BY_DIGITS = 1e-4
"""S5, or c in m: nearer to a singularity a path is led by the digits it is written in."""


class SingularPlace(NamedTuple):
    """A pass of a singularity.

    Parameters
    ----------
    kind : str
        ``"shoulder"``, ``"elbow"`` or ``"wrist"``.
    at : int
        Sample at which the index is least, next to where it changes its sign if it does.
    size : float
        Its least size: c in m, S3 or S5; 0 if the motion goes through.
    through : bool
        Whether the index changes its sign.
    swings : tuple of float
        How far the joints move that it makes fast, while the motion is near, rad.
    folded : bool
        Of the elbow: whether it is folded, not stretched.
    """

    kind: str
    at: int
    size: float
    through: bool
    swings: tuple[float, ...]
    folded: bool

    @property
    def words(self) -> str:
        """What happens there and why the branch is the one that it is."""
        if self.through:
            return {
                "shoulder": "through: the wrist goes through the axis of q1 and the arm reaches "
                "on to its other side, so that q1 need not turn",
                "elbow": f"through: the arm is {'folded' if self.folded else 'stretched'} and "
                "bends the other way, so that q3 need not turn back",
                "wrist": "through: the tool is in line with the forearm and q5 changes its sign, "
                "so that q4 and q6 need not turn",
            }[self.kind]
        swung = " and ".join(
            f"{AXIS_NAMES[joint]} turns by {math.degrees(swing):.1f} deg"
            for joint, swing in zip(_SWINGS[_KINDS.index(self.kind)], self.swings, strict=True)
        )
        missed = f"beside it at c = {1e3 * self.size:.4g} mm"
        if self.kind != "shoulder":
            missed = f"beside it by {math.degrees(math.asin(min(self.size, 1.0))):.4g} deg"
        told = f"{missed}: {swung} while it is near, on the same branch"
        if self.kind == "elbow" or max(self.swings) < _ROUND or self.size > _BY_DIGITS:
            return told
        return f"{told}; exactly through it they would not, and the digits of the path decide that"


def singular_places(indices: Array, q: Array) -> list[SingularPlace]:
    """Return the passes of a motion in the order of time.

    Parameters
    ----------
    indices : ndarray, shape (n, 3)
        c (m), S3 and S5.
    q : ndarray, shape (n, 6)
        Joints, rad.
    """
    found: list[SingularPlace] = []
    for column, kind in enumerate(_KINDS):
        index = indices[:, column]
        close = np.abs(index) < NEAR[column]
        crossing = np.concatenate((index[:-1] * index[1:] <= 0.0, [False]))
        crossing[:-1] &= index[:-1] != 0.0  # of a sample on the singularity one side is enough
        close |= crossing
        edges = np.flatnonzero(np.diff(np.concatenate(([False], close, [False])).astype(int)))
        for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            part = q[first : min(last + 1, len(q))]
            swings = tuple(float(np.ptp(part[:, joint])) for joint in _SWINGS[column])
            passes = [k for k in range(first, last) if crossing[k]]
            through = [k for k in passes if index[k] * index[_after(index, k)] < 0.0]
            nearest = first + int(np.argmin(np.abs(index[first:last])))
            nearer = [k + int(abs(index[k + 1]) < abs(index[k])) for k in through]
            for k in nearer or [nearest]:
                folded = kind == "elbow" and math.cos(float(q[k, 2])) < 0.0
                size = 0.0 if through else float(abs(index[nearest]))
                found.append(SingularPlace(kind, k, size, bool(through), swings, folded))
    return sorted(found, key=lambda place: place.at)


def least_size(index: Array) -> float:
    """Return how near a motion comes to a singularity: the least size of c (m), S3 or S5.

    Parameters
    ----------
    index : ndarray, shape (n,)
        Of that singularity; where it changes its sign, the motion goes through.
    """
    return 0.0 if np.any(index[:-1] * index[1:] < 0.0) else float(np.abs(index).min())


def _after(index: Array, k: int) -> int:
    """Return the next sample that is not on the singularity itself."""
    following = np.flatnonzero(index[k + 1 :])
    return k + 1 + int(following[0]) if len(following) else k
