"""Which device of a rig acts last by itself, once its program has died."""

from typing import NamedTuple

from rig.config import Profile


class Slowest(NamedTuple):
    """The device of a profile that acts last by itself when the program has died.

    Parameters
    ----------
    device : str
        Its name.
    after : float
        s.
    """

    device: str
    after: float


def slowest_device(profile: Profile) -> Slowest | None:
    """Return the device that takes setpoints and acts last; None: no driver says of one."""
    found = []
    for name, entry in profile.devices.items():
        bus = None if entry.bus is None else profile.buses[entry.bus].settings
        after = entry.settings.acts_after(bus)
        if after is not None:
            found.append(Slowest(name, after))
    return max(found, key=lambda one: one.after, default=None)
