"""Whether the plant of a profile has what its devices are mounted on, before anything is made."""

from collections.abc import Iterator

from rig.assembly.registry import REGISTRY
from rig.config import Profile
from rig.config.dump import plain_of
from rig.config.located import Plain, places_named
from rig.hal import SeveralErrors
from rig.hal.world import BY_CHANNEL


def check_channels(profile: Profile) -> None:
    """Refuse devices and scheduled faults of a channel that there is not: none can be simulated.

    Raises
    ------
    SeveralErrors
        With the setting, its place, and the channels that there are.
    """
    told = [*_devices_nowhere(profile), *_faults_nowhere(profile)]
    SeveralErrors.raise_if_any([places_named(text, profile.places) for text in told])


def _devices_nowhere(profile: Profile) -> Iterator[str]:
    model = "" if profile.plant is None else profile.plant.model
    known = REGISTRY.plant_channels(model)
    devices = plain_of(profile)["devices"]
    if not known:  # nobody says before the plant is made
        return
    for name, entry in profile.devices.items():
        if not REGISTRY.driver(entry.driver).on_bus:
            continue
        for channel in entry.settings.channel_names():
            if channel in known:
                continue
            said = where_said(channel, devices[name] if isinstance(devices, dict) else None)
            where = ".".join(("devices", name, *said))
            yield (
                f"{where}: the plant {model} has no channel {channel}; it has {', '.join(known)}. "
                f"To simulate what no plant knows, the driver {entry.driver} names a simulation "
                "of its own (DriverParts.simulation)"
            )


def _faults_nowhere(profile: Profile) -> Iterator[str]:
    channels = channels_of(profile)
    for fault in profile.simulation.faults:
        names = channels.get(fault.device, ())
        number = 0.0 if fault.size is None else fault.size
        if fault.fault in BY_CHANNEL and names and number not in range(len(names)):
            known = ", ".join(f"{k} ({name})" for k, name in enumerate(names))
            yield (
                f"simulation.faults: the value of {fault.fault} is the number of a channel of "
                f"{fault.device}: {known}; not {number:g}"
            )


def channels_of(profile: Profile) -> dict[str, tuple[str, ...]]:
    """Return the names of each device's channels, and of the plant's as far as its row says."""
    found: dict[str, tuple[str, ...]] = {
        name: entry.settings.channel_names() for name, entry in profile.devices.items()
    }
    if profile.plant is not None:
        found["plant"] = REGISTRY.plant_channels(profile.plant.model)
    return found


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
