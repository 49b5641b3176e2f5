"""The camera of the spherical joint: whether it looks at the joint's own marker."""

from rig.hal import ConfigurationError, MarkerCamera
from rig.mechanisms.joint.settings import JointSettings

_SAME_SPHERE = 0.2e-3
"""A marker's distance from the centre may be calibrated on either side, and differ by this, m."""


def check_camera(settings: JointSettings, camera: MarkerCamera) -> None:
    """Refuse a camera that takes the marker to be elsewhere than the joint does.

    Raises
    ------
    ConfigurationError
        The sphere that its rays end on is not the marker's.
    """
    radius, height = camera.sphere_radius, settings.geometry.marker_height
    if radius is not None and abs(radius - height) > _SAME_SPHERE:
        raise ConfigurationError(
            f"{camera.name}: marker.sphere_radius is {radius * 1e3:.3f} mm, but joint.geometry."
            f"marker_height is {height * 1e3:.3f} mm; both say how far the marker is from the "
            f"ball's centre and may differ by {_SAME_SPHERE * 1e3:g} mm"
        )
