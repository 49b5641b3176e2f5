"""The devices of the spherical joint: whether they can do what it needs."""

from rig.hal import ConfigurationError, LinearEncoder, MarkerCamera, PressureRegulator
from rig.mechanisms.base import CLAMPED
from rig.mechanisms.joint_columns import CHANNELS
from rig.mechanisms.joint_settings import JointSettings

_SAME_SPHERE = 0.2e-3
"""A marker's distance from the centre may be calibrated on either side, and differ by this, m."""


def check_camera(settings: JointSettings, camera: MarkerCamera) -> None:
    """Refuse a camera that takes the marker to be elsewhere than the joint does.

    Raises
    ------
    ConfigurationError
        The sphere that its rays end on is not the marker's.
    """
    radius, height = getattr(camera, "sphere_radius", None), settings.geometry.marker_height
    if radius is not None and abs(radius - height) > _SAME_SPHERE:
        raise ConfigurationError(
            f"{camera.name}: marker.sphere_radius is {radius * 1e3:.3f} mm, but joint.geometry."
            f"marker_height is {height * 1e3:.3f} mm; both say how far the marker is from the "
            f"ball's centre and may differ by {_SAME_SPHERE * 1e3:g} mm"
        )


def check_devices(
    settings: JointSettings, regulators: PressureRegulator, encoders: tuple[LinearEncoder, ...]
) -> None:
    """Refuse devices that cannot do what the joint needs.

    Raises
    ------
    ConfigurationError
        They have other channels, or ranges that do not hold the limits.
    """
    if tuple(regulators.channels) != CHANNELS:
        raise ConfigurationError(
            f"{regulators.name}: the channels are {', '.join(regulators.channels)}; "
            f"the joint needs {', '.join(CHANNELS)} in this order"
        )
    low, high = regulators.pressure_range
    # A calibrated module ends a little above or below what its maker says, and is clamped there.
    low, high = low - CLAMPED * (high - low), high + CLAMPED * (high - low)
    if settings.limits.pressure[0] < low or settings.limits.pressure[1] > high:
        raise ConfigurationError(
            f"limits.pressure {settings.limits.pressure[0]:g} … {settings.limits.pressure[1]:g} Pa "
            f"exceeds what {regulators.name} can set, {low:g} … {high:g} Pa"
        )
    for encoder in encoders:
        if len(encoder.channels) != 1:
            raise ConfigurationError(
                f"{encoder.name}: it has {len(encoder.channels)} channels, a rod needs one"
            )
        if encoder.stroke < settings.stroke:
            raise ConfigurationError(
                f"{encoder.name}: its stroke {encoder.stroke:g} m is shorter than the "
                f"cylinder's, {settings.stroke:g} m"
            )
