"""What procedures need to know of a mechanism: its channels, devices and types."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rig.config import Profile


class Pneumatics(NamedTuple):
    """A mechanism whose rods are pulled by pneumatic cylinders.

    Parameters
    ----------
    regulators : str
        The device.
    channels : tuple of str
        Its channels, in order.
    encoders : tuple of str
        The rods' encoders, in the order of the channels.
    lowest, highest : float
        Pressures that every chamber may have at once, Pa gauge.
    """

    regulators: str
    channels: tuple[str, ...]
    encoders: tuple[str, ...]
    lowest: float
    highest: float


def pneumatics_of(profile: Profile) -> Pneumatics:
    """Return the pneumatic side of a ``cylinder`` or ``joint`` profile."""
    settings = profile.mechanism_settings
    low, high = settings.limits.pressure
    if profile.mechanism == "cylinder":
        encoders = (settings.encoder_agonist, settings.encoder_antagonist)
    else:
        encoders = tuple(settings.encoders)
        least, most = settings.limits.tension
        low, high = max(low, least / settings.area), min(high, most / settings.area)
    channels = tuple(profile.devices[settings.regulators].settings.channels)
    span = high - low
    return Pneumatics(
        settings.regulators, channels, encoders, low + 0.06 * span, high - 0.08 * span
    )


def open_loop(
    profile: Profile, times: Sequence[float], pressures: Sequence[Sequence[float]], segments: Any
) -> Any:
    """Return motion and controller in one, which gives pressures and leaves the pose alone."""
    from rig.calibration.excitation import OpenLoop

    if profile.mechanism == "cylinder":
        from controllers.cylinder.types import PairCommand, PairEstimate, PairReference

        return OpenLoop(
            times, pressures, segments,
            rest=PairReference(0.0, 0.0, 0.0), command=PairCommand,
            estimate=PairEstimate(0.0, 0.0),
        )  # fmt: skip
    from controllers.spherical_joint.types import JointCommand, JointEstimate, JointReference

    nothing = (0.0, 0.0, 0.0)
    return OpenLoop(
        times, pressures, segments,
        rest=JointReference((0.0, 0.0, 1.0), nothing, nothing), command=JointCommand,
        estimate=JointEstimate(nothing, nothing, 0.0, (0.0,) * 4, (0.0,) * 4),
    )  # fmt: skip
