"""Write a profile or experiment as it was understood: everything said, in SI."""

import re
from dataclasses import fields, is_dataclass
from typing import Any, Final

import yaml

from rig.config.models import BusEntry, DeviceEntry, Experiment, PlantEntry, Profile, ReferenceEntry
from rig.hal import ConfigurationError

_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_./+-]*")


class _Dumper(yaml.SafeDumper):
    """Writes what the strict loader reads back: no aliases, quotes wherever they might matter."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def _represent_text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = None if _PLAIN.fullmatch(text) else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _represent_text)


def dump_resolved(resolved: Profile | Experiment) -> str:
    """Return a profile or experiment as YAML text.

    Parameters
    ----------
    resolved : Profile or Experiment
        What was loaded.

    Returns
    -------
    str
        A file without ``extends``, options or defaults left out, numbers in SI. Loading it
        gives an equal object; calibrations are in it and are not laid over once more.
    """
    content = _profile(resolved) if isinstance(resolved, Profile) else as_plain(resolved)
    del content["files"]
    return yaml.dump(
        content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100,
        default_flow_style=None,
    )  # fmt: skip


def setting_of(name: str, profile: Profile, experiment: Experiment) -> Any:
    """Return a setting of a rig or an experiment by its dotted name, as in ``--set``.

    Raises
    ------
    ConfigurationError
        There is none of that name.
    """
    found: Any = {**_profile(profile), **as_plain(experiment)}
    for key in name.split("."):
        if not isinstance(found, dict) or key not in found:
            known = ", ".join(found) if isinstance(found, dict) else "nothing below that"
            raise ConfigurationError(f"there is no setting {name!r}: no {key!r}; there is {known}")
        found = found[key]
    return found


def _profile(profile: Profile) -> dict[str, Any]:
    content: dict[str, Any] = as_plain(profile)
    settings = content.pop("mechanism_settings")
    del content["uncalibrated"]
    # Said in any case, so that a resolved profile is not calibrated once more.
    content["calibration"] = content["calibration"] or False
    ordered: dict[str, Any] = {}
    for key, value in content.items():
        if key == "plant" and value is None:
            continue
        ordered[key] = value
        if key == "devices":
            _name_copies(profile, value)
            ordered[profile.mechanism] = settings
    return ordered


def _name_copies(profile: Profile, devices: dict[str, Any]) -> None:
    """Name the copies that a run folder keeps of the devices' own files."""
    for name, entry in profile.devices.items():
        if entry.eds is not None:
            devices[name]["eds"] = f"eds/{name}.eds"


def as_plain(value: Any) -> Any:
    """Return settings as plain mappings, lists and scalars, in SI."""
    if isinstance(value, DeviceEntry):
        own = as_plain(value.settings)
        calibration = False if value.calibration is None else as_plain(value.calibration)
        common = {"driver": value.driver, "bus": value.bus, "serial": value.serial}
        return {**common, "calibration": calibration, **own}
    if isinstance(value, BusEntry):
        return {"protocol": value.protocol, **as_plain(value.settings)}
    if isinstance(value, PlantEntry):
        return {"model": value.model, **as_plain(value.settings)}
    if isinstance(value, ReferenceEntry):
        return {"kind": value.kind, **as_plain(value.settings)}
    if is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: as_plain(getattr(value, field.name))
            for field in fields(value)
            if field.init
        }
    if isinstance(value, dict):
        return {key: as_plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [as_plain(item) for item in value]
    return value
