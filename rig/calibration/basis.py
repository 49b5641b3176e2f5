"""What of a profile a measurement rests on: dimensions of the mechanism, and what readings mean."""

from rig.assembly import REGISTRY
from rig.config import Profile
from rig.config.basis import stated


def basis_of(profile: Profile, target: str, *, with_dimensions: bool) -> dict[str, str]:
    """Return what a profile says that the calibration of a target rests on.

    Parameters
    ----------
    profile : Profile
        The one that it was measured under.
    target : str
        A device, whose readings alone are looked at; or the mechanism, for which all devices are.
    with_dimensions : bool
        Whether the mechanism's dimensions count for a device, too.

    Returns
    -------
    dict of str to str
        Texts with units, by dotted names.
    """
    whole = target == profile.mechanism
    devices = [
        f"devices.{name}.{key}"
        for name, entry in profile.devices.items()
        if whole or name == target
        for key in entry.settings.scaling
    ]
    return stated(profile, [*(_dimensions(profile) if whole or with_dimensions else ()), *devices])


def basis_of_gains(profile: Profile) -> dict[str, str]:
    """Return what a profile says that gains of a law rest on, besides their calibrations."""
    believed = REGISTRY.load("mechanism", profile.mechanism).believed
    named = [f"{profile.mechanism}.{key}" for key in believed]
    return stated(profile, ["loop.rate", *_dimensions(profile), *named])


def _dimensions(profile: Profile) -> list[str]:
    dimensions = REGISTRY.load("mechanism", profile.mechanism).dimensions
    return [f"{profile.mechanism}.{key}" for key in dimensions]
