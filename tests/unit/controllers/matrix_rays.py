"""The ray (adj(J) u, det J) of any chain, by singular values: what closed forms are held against.

A path asks for ``J q' = u xi'``. Its solutions form a ray in the space of joint rates and path
rate, ``(q', xi') = b (adj(J) u, det J)`` with a free scale b; the ray exists where ``J^-1`` does
not. Where ``det J = 0`` the joints move and the path parameter stands still. Nothing here divides
by the determinant.

References
----------
Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC
approach", eq. (1) and (2).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Ray(NamedTuple):
    """Joint rates and the path rate that belongs to them, both up to one scale.

    Parameters
    ----------
    joints : ndarray, shape (n,)
        ``adj(J) u``.
    path : float
        ``det J``.
    """

    joints: Array
    path: float

    def unit(self) -> "Ray":
        """Return the ray with joint rates of norm 1; as it is if no joint moves."""
        norm = float(np.linalg.norm(self.joints))
        return Ray(self.joints / norm, self.path / norm) if norm > 0.0 else self


def adjugate(matrix: Array) -> Array:
    """Return the adjugate of a square matrix, exact to rounding at any rank.

    ``det(U) det(V) V diag(prod of the other singular values) U'``: no division, and no sum of
    cofactors, which at twelve rows cancels to nothing.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Any.
    """
    u, singular, vt = np.linalg.svd(matrix)
    before = np.concatenate(([1.0], np.cumprod(singular)[:-1]))
    after = np.concatenate((np.cumprod(singular[::-1])[-2::-1], [1.0]))
    sign = np.linalg.det(u) * np.linalg.det(vt)
    scaled: Array = round(sign) * (vt.T * (before * after)) @ u.T
    return scaled


def path_ray(jacobian: Array, direction: Array) -> Ray:
    """Return ``(adj(J) u, det J)``.

    Parameters
    ----------
    jacobian : ndarray, shape (n, n)
        J.
    direction : ndarray, shape (n,)
        u, the tangent of the path.
    """
    return Ray(adjugate(jacobian) @ direction, float(np.linalg.det(jacobian)))


def null_ray(jacobian: Array, direction: Array, previous: Ray | None = None) -> Ray:
    """Return the unit null vector of ``[J, -u]``, the ray without forming an adjugate.

    Where the rank falls by two (the literal ray is zero and motion would end although it could go
    on) it is the projection of the previous ray on the null space. Its sign follows `previous`.

    Parameters
    ----------
    jacobian : ndarray, shape (n, n)
        J; rows of a length and of an angle are better scaled to one size.
    direction : ndarray, shape (n,)
        u, scaled alike.
    previous : Ray, optional
        The last one on this path; without it the path parameter grows.
    """
    _, singular, vt = np.linalg.svd(np.column_stack((jacobian, -direction)))
    rank = int(np.sum(singular > singular[0] * len(singular) * np.finfo(float).eps * 16.0))
    basis = vt[rank:]
    if previous is None:
        vector = basis[-1]
        sign = 1.0 if vector[-1] >= 0.0 else -1.0
    else:
        last = np.concatenate((previous.joints, [previous.path]))
        vector = basis.T @ (basis @ last)
        if not np.any(vector):
            vector = basis[-1]
        sign = 1.0 if vector @ last >= 0.0 else -1.0
    vector = sign * vector / np.linalg.norm(vector)
    return Ray(vector[:-1], float(vector[-1]))
