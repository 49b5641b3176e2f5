"""What the settings of a profile and its mechanism answer, asked once before anything is opened.

The answers are used in many places, deep inside; one of a wrong type is said here, with its name.
"""

from dataclasses import is_dataclass
from math import isnan
from typing import Final

from rig.assembly.contract_check import ask, check_offers
from rig.assembly.registry import REGISTRY
from rig.config import Profile
from rig.hal import ContractBroken, DriverSettings, Mechanism
from rig.hal.driver import BusSettings
from rig.hal.fits import shown
from rig.hal.motion import Motion
from rig.hal.plant import PhysicsSettings

_LONGEST = 7 * 86_400.0
"""No motion lasts longer, s: one that is asked for by mistake would run until the disk is full."""
_ASKED: Final = (
    "wiring", "geometry_of", "limits_of", "expected_of", "described", "constants_of", "unfit",
)  # fmt: skip
"""Of a mechanism's class, with the profile's section."""


def check_answers(profile: Profile) -> None:
    """Refuse settings, and a mechanism, that answer with something of another type.

    Raises
    ------
    ContractBroken
        With whose answer, to what, it is.
    """
    for name, device in profile.devices.items():
        settings = device.settings
        what = f"{name}: the settings of the driver {device.driver}"
        bus = None if device.bus is None else profile.buses[device.bus].settings
        ask(what, DriverSettings, "channel_names", settings)
        ask(what, DriverSettings, "addresses", settings, name, device.serial)
        ask(what, DriverSettings, "acts_after", settings, bus)
    for name, entry in profile.buses.items():
        what = f"{name}: the settings of the protocol {entry.protocol}"
        check_offers(what, entry.settings, BusSettings)
        ask(what, BusSettings, "endpoint", entry.settings)
    if profile.plant is not None:
        what = f"the settings of the plant {profile.plant.model}"
        ask(what, PhysicsSettings, "variant", profile.plant.settings)
    what = f"the mechanism {profile.mechanism}"
    view = REGISTRY.load("mechanism", profile.mechanism)
    for method in _ASKED:
        ask(what, Mechanism, method, view, profile.mechanism_settings)
    limits = view.limits_of(profile.mechanism_settings)
    if limits is not None and (isinstance(limits, type) or not is_dataclass(limits)):
        raise ContractBroken(f"{what}: limits_of returned {shown(limits)}, and no dataclass")


def check_motion(what: str, motion: Motion[object], period: float) -> None:
    """Refuse a motion that is none, that never ends, or whose segments it does not come to.

    Parameters
    ----------
    what : str
        Whose motion it is, for messages.
    motion : Motion
        As planned.
    period : float
        Of the loop, s.

    Raises
    ------
    ContractBroken
        With the attribute, what it is and what it must be.
    """
    check_offers(what, motion, Motion)
    kind = f"{what}: {type(motion).__module__}.{type(motion).__name__}"
    duration = motion.duration
    if not 0.0 <= duration <= _LONGEST:
        raise ContractBroken(
            f"{kind}.duration is {duration:g} s, and not between 0 and {_LONGEST:g} s"
        )
    for name, fact in motion.facts.items():
        if isnan(fact.value):
            raise ContractBroken(f"{kind}.facts: {name!r} is not a number")
    for segment in motion.segments:
        # Rounding may take the last sample of a motion.
        if not 0.0 <= segment.start <= segment.end <= duration + period:
            raise ContractBroken(
                f"{kind}.segments: {segment.name!r} lasts from {segment.start:g} to "
                f"{segment.end:g} s, the motion from 0 to {duration:g} s"
            )
