"""Whether the plant of a profile has what its devices are mounted on, before anything is made."""

from collections.abc import Iterator

from rig.assembly.registry import REGISTRY
from rig.config import Profile
from rig.config.dump import plain_of
from rig.config.located import Plain, places_named
from rig.hal import SeveralErrors


def check_channels(profile: Profile) -> None:
    """Refuse devices that show a channel of the plant which it has not: none can be simulated.

    Raises
    ------
    SeveralErrors
        With the setting, its place, and the channels that there are.
    """
    if profile.plant is None:
        return
    model = profile.plant.model
    known = REGISTRY.plant_channels(model)
    if not known:  # nobody says before the plant is made
        return
    devices = plain_of(profile)["devices"]
    told = []
    for name, entry in profile.devices.items():
        if not REGISTRY.driver(entry.driver).on_bus:
            continue
        for channel in entry.settings.channel_names():
            if channel in known:
                continue
            said = where_said(channel, devices[name] if isinstance(devices, dict) else None)
            where = ".".join(("devices", name, *said))
            text = (
                f"{where}: the plant {model} has no channel {channel}; it has {', '.join(known)}. "
                f"To simulate what no plant knows, the driver {entry.driver} names a simulation "
                "of its own (DriverParts.simulation)"
            )
            told.append(places_named(text, profile.places))
    SeveralErrors.raise_if_any(told)


def where_said(word: str, settings: Plain) -> tuple[str, ...]:
    """Return the keys below a device that lead to a word of its settings; none: to the device.

    Parameters
    ----------
    word : str
        Such as the name of a channel.
    settings : plain
        The device's, as `rig.config.dump.plain_of` has them.
    """
    return next(_sayings(word, settings, ()), ())


def _sayings(word: str, settings: Plain, keys: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    if settings == word:
        yield keys
    elif isinstance(settings, dict):
        for key, below in settings.items():
            if key == word:
                yield (*keys, key)
            else:
                yield from _sayings(word, below, (*keys, key))
