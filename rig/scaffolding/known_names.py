"""Names that mean something already: a second thing of one would hide the first, or be hidden."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, get_args

from rig.assembly import REGISTRY
from rig.config import PROFILE_KEYS
from rig.config.named_settings import Kind
from rig.config.names import find_file, list_files
from rig.config.yaml_loader import read_plain
from rig.hal import ConfigurationError

_EXTENDED: Final = "cylinder"
"""The profile that the one of a new driver extends: a device of its names would replace its own."""


def refuse_known_file(name: str, search: Sequence[Path]) -> None:
    """Refuse the name of a rig or an experiment that there is.

    Calibrations, run folders and latched faults go by these names.

    Parameters
    ----------
    name : str
        Of a new rig or experiment.
    search : sequence of Path
        Folders of configurations.

    Raises
    ------
    ConfigurationError
        It is taken; with by what.
    """
    _refuse([name], dict(_files(search)))


def refuse_known_part(name: str, files: Sequence[str], search: Sequence[Path]) -> None:
    """Refuse a package's name that a profile means something else by.

    Parameters
    ----------
    name : str
        Of a new law, driver or mechanism.
    files : sequence of str
        Names of the profile and the experiment that its package has.
    search : sequence of Path
        Folders of configurations.

    Raises
    ------
    ConfigurationError
        It is taken, or one of its files is; with by what.
    """
    known = {**dict(_parts(search)), **dict(_files(search))}
    _refuse([name, *files], known)


def _refuse(names: Sequence[str], known: Mapping[str, str]) -> None:
    for name in names:
        if name in known:
            new = names[0]
            written = "" if name == new else f", which {new} would have as well"
            raise ConfigurationError(
                f"{name} is {known[name]} already{written}; choose another name, as my-{new}"
            )


def _files(search: Sequence[Path]) -> Iterator[tuple[str, str]]:
    for name in list_files("experiments", search):
        yield name, "an experiment"
    for name in list_files("rigs", search):
        yield name, "a rig"


def _parts(search: Sequence[Path]) -> Iterator[tuple[str, str]]:
    for key in PROFILE_KEYS:
        yield key, "a key of profiles"
    for device in _devices(search):
        yield device, f"a device of the rig {_EXTENDED}"
    for kind in get_args(Kind):
        for name in REGISTRY.names(kind):
            yield name.rpartition("/")[2], f"a {'protocol' if kind == 'bus' else kind}"


def _devices(search: Sequence[Path]) -> Sequence[str]:
    try:
        content = read_plain(find_file(_EXTENDED, "rigs", search))
    except ConfigurationError:  # other folders than ours need not have it
        return ()
    devices = content.get("devices") if isinstance(content, dict) else None
    return list(devices) if isinstance(devices, dict) else ()
