"""Write a loaded profile or experiment as YAML: every setting, in SI."""

import re
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Final

import yaml

from rig.config.located import Plain
from rig.config.models import BusEntry, DeviceEntry, Experiment, PlantEntry, Profile, ReferenceEntry
from rig.config.named_files import copies_of
from rig.hal import ConfigurationError

REFERENCE_FILES: Final = "reference"
"""The folder in a run folder with the files that the reference names."""

_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_./+-]*")


class _Dumper(yaml.SafeDumper):
    """Writes what the strict loader reads back: no aliases, quotes wherever they might matter."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = None if _PLAIN.fullmatch(text) else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent_text)


def dump_resolved(resolved: Profile | Experiment) -> str:
    """Return a profile or experiment as YAML text.

    Returns
    -------
    str
        A file without ``extends``, options or defaults left out, numbers in SI. Loading it
        gives an equal object; calibrations are in it and are not laid over once more.
    """
    return yaml.dump(
        plain_of(resolved), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100,
        default_flow_style=None,
    )  # fmt: skip


def plain_of(resolved: Profile | Experiment) -> dict[str, Plain]:
    """Return a profile or experiment as plain data: what `dump_resolved` writes."""
    return _profile(resolved) if isinstance(resolved, Profile) else _entries(resolved)


def setting_of(name: str, profile: Profile, experiment: Experiment) -> Plain:
    """Return a setting of a rig or an experiment by its dotted name, as in ``--set``.

    Raises
    ------
    ConfigurationError
        There is none of that name.
    """
    found: Plain = {**_profile(profile), **_entries(experiment)}
    for key in name.split("."):
        if not isinstance(found, dict) or key not in found:
            known = ", ".join(found) if isinstance(found, dict) else "nothing below that"
            raise ConfigurationError(f"there is no setting {name!r}: no {key!r}; there is {known}")
        found = found[key]
    return found


def _profile(profile: Profile) -> dict[str, Plain]:
    return {
        "name": profile.name,
        "description": profile.description,
        "mechanism": profile.mechanism,
        **({"additions": list(profile.additions)} if profile.additions else {}),
        "loop": as_plain(profile.loop),
        "buses": as_plain(profile.buses),
        "devices": {name: _device(name, entry) for name, entry in profile.devices.items()},
        profile.mechanism: as_plain(profile.mechanism_settings),
        "controllers": as_plain(profile.controllers),
        **({} if profile.plant is None else {"plant": as_plain(profile.plant)}),
        "simulation": as_plain(profile.simulation),
        # Said in any case, so that a resolved profile is not calibrated once more.
        "calibration": as_plain(profile.calibration) or False,
    }


def _device(name: str, entry: DeviceEntry) -> dict[str, Plain]:
    return {
        "driver": entry.driver,
        "bus": entry.bus,
        "serial": entry.serial,
        "calibration": as_plain(entry.calibration) or False,
        **_entries(entry.settings),
        # The copy that a run folder keeps of the device's own file.
        **({} if entry.eds is None else {"eds": f"eds/{name}.eds"}),
    }


def _entries(value: object) -> dict[str, Plain]:
    """Return what a dataclass says, key by key, without what is no part of its value."""
    assert is_dataclass(value)
    return {
        field.name: as_plain(getattr(value, field.name))
        for field in fields(value)
        if field.init and field.compare
    }


def _reference(entry: ReferenceEntry) -> dict[str, Plain]:
    plain: dict[str, Plain] = {"kind": entry.kind, **_entries(entry.settings)}
    for keys, copy in copies_of(entry.settings, REFERENCE_FILES).items():
        below = plain
        for key in keys[:-1]:
            inner = below[key]
            assert isinstance(inner, dict)
            below = inner
        below[keys[-1]] = copy  # that a run folder keeps
    return plain


def as_plain(value: object) -> Plain:
    """Return settings as plain mappings, lists and scalars, in SI."""
    if isinstance(value, BusEntry):
        return {"protocol": value.protocol, **_entries(value.settings)}
    if isinstance(value, PlantEntry):
        return {"model": value.model, **_entries(value.settings)}
    if isinstance(value, ReferenceEntry):
        return _reference(value)
    if is_dataclass(value):
        return _entries(value)
    if isinstance(value, dict):
        return {key: as_plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [as_plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    assert value is None or isinstance(value, str | int | float)
    return value
