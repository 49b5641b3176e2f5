"""The course of the acceptance test of any mechanism with pneumatic cylinders."""

from collections.abc import Callable, Sequence

from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep
from rig.commissioning.steps.identity import OnTheBus, SettingsReadBack
from rig.commissioning.steps.load import Load
from rig.commissioning.steps.motion import FirstMotion
from rig.commissioning.steps.reactions import CablePulled, MasterDies, StopReaction
from rig.commissioning.steps.stop import EmergencyStopContact
from rig.mechanisms.pneumatic.commissioning.actuators import RegulatorsAlone
from rig.mechanisms.pneumatic.commissioning.ends import RodsToTheirEnds
from rig.mechanisms.pneumatic.commissioning.leak import LeaksOfChambers
from rig.mechanisms.pneumatic.commissioning.reactions import REACTING
from rig.mechanisms.pneumatic.commissioning.response import ResponseTimes
from rig.mechanisms.pneumatic.commissioning.sensors import EncodersByHand
from rig.mechanisms.pneumatic.commissioning.supply import SupplyAndDump
from rig.mechanisms.pneumatic.settings import PneumaticSettings


def pneumatic_course(
    motion: FirstMotion, way: Callable[[PneumaticSettings], float]
) -> Sequence[AcceptanceStep]:
    """Return the steps in their order, each on what the ones before have proven.

    Parameters
    ----------
    motion : FirstMotion
        The mechanism's own, which comes last.
    way : callable
        ``way(settings)`` returns how far a rod goes from home where the profile permits most, m.
    """
    return (
        OnTheBus(),
        SettingsReadBack(),
        EmergencyStopContact(),
        SupplyAndDump(),
        StopReaction(REACTING),
        MasterDies(REACTING),
        CablePulled(REACTING),
        EncodersByHand(),
        RegulatorsAlone(),
        ResponseTimes(),
        LeaksOfChambers(),
        RodsToTheirEnds(way),
        Load(),
        motion,
    )


def following(site: Site) -> float:
    """Return how far a rod may be from its reference, m: what the profile permits for a moment."""
    settings = site.profile.mechanism_settings
    assert isinstance(settings, PneumaticSettings)
    return settings.limits.following
