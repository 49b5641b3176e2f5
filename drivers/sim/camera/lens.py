"""What a driver makes of a ray that came through another lens than it believes in."""

from typing import Final

from drivers.marker_camera.settings import IntrinsicsSettings

_STEPS: Final = 50

Ray = tuple[float, float]
"""x/z and y/z."""


def believed_ray(ray: Ray, true: IntrinsicsSettings, believed: IntrinsicsSettings) -> Ray:
    """Return the ray that the believed lens has for the pixel on which a ray really ends.

    Parameters
    ----------
    ray : tuple of float
        Before the lens.
    true, believed : IntrinsicsSettings
        The camera's lens, and what its driver was told.
    """
    if true == believed:
        return ray
    x, y = _bent(ray, true)
    goal_x = (true.fx * x + true.cx - believed.cx) / believed.fx
    goal_y = (true.fy * y + true.cy - believed.cy) / believed.fy
    x, y = goal_x, goal_y
    for _ in range(_STEPS):  # a lens bends little: what is missing is added until nothing is
        bent_x, bent_y = _bent((x, y), believed)
        x, y = x + goal_x - bent_x, y + goal_y - bent_y
    return x, y


def _bent(ray: Ray, lens: IntrinsicsSettings) -> Ray:
    """Return where a ray meets the image, as Brown and Conrady have it, in focal lengths."""
    x, y = ray
    q = x * x + y * y
    g = 1.0 + q * lens.k1 + q * q * lens.k2 + q**3 * lens.k3
    return (
        g * x + 2.0 * lens.p1 * x * y + lens.p2 * (q + 2.0 * x * x),
        g * y + 2.0 * lens.p2 * x * y + lens.p1 * (q + 2.0 * y * y),
    )
