"""Regulators and encoders of pneumatic cylinders: whether they can do what a mechanism needs."""

from collections.abc import Sequence
from typing import Final

from rig.hal import LinearEncoder, PressureRegulator, SafetyError, SeveralErrors

_CLAMPED: Final = 0.05
"""Share of a regulator's range by which a limit may exceed it: a calibrated module ends a little
above or below what its maker says, and is clamped there."""

_FAR: Final = 10.0
"""A command of so many times the greatest pressure is no law's doing: in the shipped experiments
they ask for 0.94 of it at most."""


def settable(limits: tuple[float, float], regulators: PressureRegulator) -> tuple[float, float]:
    """Return the least and greatest setpoint, Pa gauge, that is permitted and can be given.

    A calibrated regulator may begin a little above the least that the profile permits.
    """
    lowest, highest = regulators.pressure_range
    return max(limits[0], lowest), min(limits[1], highest)


def check_asked_pressures(
    channels: Sequence[str], pressures: Sequence[float], greatest: float
) -> None:
    """Raise if a controller asks for pressures that no law in its right mind asks for.

    What is only beyond the range is clamped later: a law with an integral may well ask for it.

    Parameters
    ----------
    channels : sequence of str
        The chambers.
    pressures : sequence of float
        What is asked for, Pa gauge.
    greatest : float
        That is permitted, Pa gauge.

    Raises
    ------
    SafetyError
        One is far outside, or no number.
    """
    far = _FAR * greatest
    for k, pressure in enumerate(pressures):
        if not -far <= pressure <= far:
            raise SafetyError(
                f"the controller's command of {channels[k]} is {pressure:.4g} Pa, "
                f"{-far:.4g} … {far:.4g} Pa is allowed"
            )


def check_pneumatics(
    whose: str,
    channels: tuple[str, ...],
    pressure: tuple[float, float],
    stroke: float,
    regulators: PressureRegulator,
    encoders: Sequence[LinearEncoder],
) -> None:
    """Refuse devices that cannot do what cylinders need.

    Parameters
    ----------
    whose : str
        The mechanism, as a message names it: ``"the joint"``.
    channels : tuple of str
        Its chambers, in their order.
    pressure : tuple of float
        Least and greatest setpoint that it may give, Pa gauge.
    stroke : float
        Of each cylinder, m.
    regulators : PressureRegulator
        Of all chambers.
    encoders : sequence of LinearEncoder
        One to each rod.

    Raises
    ------
    ConfigurationError
        They have other channels, or ranges that do not hold the limits.
    """
    found: list[str] = []
    if tuple(regulators.channels) != channels:
        found.append(
            f"{regulators.name}: the channels are {', '.join(regulators.channels)}; "
            f"{whose} needs {', '.join(channels)} in this order"
        )
    low, high = regulators.pressure_range
    low, high = low - _CLAMPED * (high - low), high + _CLAMPED * (high - low)
    if pressure[0] < low or pressure[1] > high:
        found.append(
            f"limits.pressure {pressure[0]:g} … {pressure[1]:g} Pa "
            f"exceeds what {regulators.name} can set, {low:g} … {high:g} Pa"
        )
    for encoder in encoders:
        if len(encoder.channels) != 1:
            found.append(
                f"{encoder.name}: it has {len(encoder.channels)} channels, a rod needs one"
            )
        if encoder.stroke < stroke:
            found.append(
                f"{encoder.name}: its stroke {encoder.stroke:g} m is shorter than the "
                f"cylinder's, {stroke:g} m"
            )
    SeveralErrors.raise_if_any(found)
