"""Several chains on one path: one path rate for all of them.

References
----------
Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC
approach", eq. (2) and (3).
"""

import math

from controllers.compiled import inlined


@inlined
def one_rate(one: float, other: float) -> tuple[float, float, float]:
    """Return by what the rays of two chains are scaled to have one path rate, and that rate.

    ``(det_2 adj(J_1) u_1, det_1 adj(J_2) u_2, det_1 det_2)``, the adjugate of the block-diagonal
    Jacobian of eq. (3); scaled, because products of two determinants get tiny. A chain without
    demand must be left out: if it is singular it would stop the other one. Where both are singular
    all three are zero; see `two_starts`.

    Parameters
    ----------
    one, other : float
        Path rates of the two rays, their determinants up to a constant.
    """
    scale = max(abs(one), abs(other))
    if scale == 0.0:
        return 0.0, 0.0, 0.0
    return other / scale, one / scale, one * (other / scale)


@inlined
def two_starts(one: float, other: float) -> tuple[float, float]:
    """Return by what two rays are scaled to leave a path point where both chains are singular.

    There any two scales solve ``J q' = u xi'`` with ``xi' = 0``. Only one pair of them starts a
    curve: along the joints the determinants grow from zero as ``s_k (grad det_k · adj_k u_k)``,
    and the path rates, ``det_k / s_k`` each, must agree.

    Parameters
    ----------
    one, other : float
        Growth of each determinant along its own ray, ``grad det · (adj(J) u)``; not zero, which
        would be a path that runs along the singularity and singles no direction out.

    Returns
    -------
    one, other : float
        Scales of the two rays, positive; the larger is 1.
    """
    first, second = math.sqrt(abs(other)), math.sqrt(abs(one))
    larger = max(first, second)
    return first / larger, second / larger
