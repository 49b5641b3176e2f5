"""How far along the ray in one second: the free scale b of the singularity-consistent method.

Any b >= 0 is a time law; the curve that the joints describe stays the same.
"""

from collections.abc import Sequence

from controllers.singularity.ray import Ray


def scale_for_rates(ray: Ray, max_rates: Sequence[float]) -> float:
    """Return the greatest b that keeps every joint within its rate.

    Parameters
    ----------
    ray : Ray
        Of this instant.
    max_rates : sequence of float
        One per joint, rad/s.

    Returns
    -------
    float
        Infinite if no joint moves.

    References
    ----------
    Kameta, Sekiguchi, Tsumaki and Nenchev, "Walking control around singularity using the SC
    approach", eq. (2): b may be chosen so that no joint rate becomes excessive.
    """
    return min(
        (
            limit / abs(rate)
            for rate, limit in zip(ray.joints.tolist(), max_rates, strict=True)
            if rate
        ),
        default=float("inf"),
    )


def scale_for_norm(ray: Ray, rate: float) -> float:
    """Return the b at which the norm of the joint rates is `rate` (rad/s)."""
    norm = float((ray.joints @ ray.joints) ** 0.5)
    return rate / norm if norm > 0.0 else float("inf")


def scale_for_path(ray: Ray, rate: float) -> float:
    """Return the b at which the path parameter grows at `rate` (1/s); infinite at a singularity.

    The one division by the determinant there is: it bounds b from above and never sets it there.
    """
    return rate / abs(ray.path) if ray.path else float("inf")
