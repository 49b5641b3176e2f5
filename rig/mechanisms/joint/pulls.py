"""What the pulls on the ring should do, for the one who looks for what they do not explain."""

from controllers.spherical_joint.falling import falling_stiffness
from controllers.spherical_joint.geometry import PAIRS
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.alarms.balance import PullBalance


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
        -falling_stiffness(settings.geometry, 1.0),
    )
