"""The course of the acceptance test of any mechanism on servo axes."""

from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.identity import OnTheBus, SettingsReadBack
from rig.commissioning.steps.load import Load
from rig.commissioning.steps.motion import FirstMotion, Moved
from rig.commissioning.steps.reactions import CablePulled, MasterDies, StopReaction
from rig.commissioning.steps.stop import EmergencyStopContact
from rig.mechanisms.servo.commissioning.axes import bear
from rig.mechanisms.servo.commissioning.directions import AxesAlone
from rig.mechanisms.servo.commissioning.ends import AxesToTheirEnds
from rig.mechanisms.servo.commissioning.first_motion import TRAVEL, axis_by_axis
from rig.mechanisms.servo.commissioning.hold import HoldStill
from rig.mechanisms.servo.commissioning.ranges import AxesInRange
from rig.mechanisms.servo.commissioning.reactions import REACTING


def servo_course(
    names: Sequence[str], own: Sequence[AcceptanceStep] = ()
) -> Sequence[AcceptanceStep]:
    """Return the steps in their order, each on what the ones before have proven.

    Parameters
    ----------
    names : sequence of str
        Of the axes.
    own : sequence of AcceptanceStep, optional
        The mechanism's own steps that need no energy.
    """
    moved = Moved([f"reading.position_{name}" for name in names], TRAVEL, "rad", all=True)
    return (
        OnTheBus(),
        SettingsReadBack(),
        EmergencyStopContact(),
        AxesInRange(),
        *own,
        HoldStill(),
        StopReaction(REACTING),
        MasterDies(REACTING),
        CablePulled(REACTING),
        AxesAlone(),
        AxesToTheirEnds(),
        Load(),
        FirstMotion(moved, axis_by_axis, bear),
    )
