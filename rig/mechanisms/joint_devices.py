"""The devices of the spherical joint: whether they can do what it needs."""

from rig.hal import ConfigurationError, LinearEncoder, PressureRegulator
from rig.mechanisms.base import CLAMPED
from rig.mechanisms.joint_columns import CHANNELS
from rig.mechanisms.joint_settings import JointSettings


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
