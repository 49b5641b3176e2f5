"""The course of the acceptance test of any mechanism with pneumatic cylinders."""

from collections.abc import Sequence

from rig.commissioning.step import Step
from rig.commissioning.steps.identity import Identity, OnTheBus
from rig.commissioning.steps.load import Load
from rig.commissioning.steps.motion import FirstMotion
from rig.commissioning.steps.stop import EmergencyStopContact
from rig.mechanisms.pneumatic.commissioning.actuators import Regulators, Response
from rig.mechanisms.pneumatic.commissioning.reactions import CablePulled, MasterDies, StopReaction
from rig.mechanisms.pneumatic.commissioning.sensors import Encoders
from rig.mechanisms.pneumatic.commissioning.supply import SupplyAndDump


def pneumatic_course(motion: FirstMotion) -> Sequence[Step]:
    """Return the steps in their order, each on what the ones before have proven.

    Parameters
    ----------
    motion : FirstMotion
        The mechanism's own, which comes last.
    """
    return (
        OnTheBus(),
        Identity(),
        EmergencyStopContact(),
        SupplyAndDump(),
        StopReaction(),
        MasterDies(),
        CablePulled(),
        Encoders(),
        Regulators(),
        Response(),
        Load(),
        motion,
    )
