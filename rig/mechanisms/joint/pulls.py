"""What the pulls on the ring should do, for the one who looks for what they do not explain."""

from controllers.spherical_joint.falling import Falling, falling_pull
from controllers.spherical_joint.geometry import PAIRS
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.alarms.balance import PullBalance

_FAR = 0.75
"""Share of the tilt that is permitted at which the ring's fall is met exactly; E."""


def pull_balance(settings: JointSettings, regulators: str) -> PullBalance:
    """Return the balance of a joint's two pairs, with the ring that falls.

    Parameters
    ----------
    settings : JointSettings
        Of the joint.
    regulators : str
        Their name, for messages.
    """
    return PullBalance(
        settings.area,
        settings.moving_mass,
        settings.friction.of_pair(settings.area * settings.base_pressure),
        PAIRS,
        CHANNELS,
        regulators,
        "the ring",
        ring_falls(settings).pull,
    )


def ring_falls(settings: JointSettings) -> Falling:
    """Return how even tensions pull on a ring that leans."""
    return falling_pull(settings.geometry, _FAR * settings.limits.tilt)
