"""Calibration files: measured values of one device, laid over its settings in the profile.

``calibration/<rig>/<device>.yaml`` holds ``values``, in the words of the device's settings,
and ``provenance``. The profile stays as it was written; what was laid over it stands in the
resolved profile of every run.
"""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.document import merge, parse_mapping, with_plain_quantities
from rig.config.models import Calibration, Provenance
from rig.config.settings import build
from rig.config.source import BROKEN, Node
from rig.config.yaml_loader import read_source

COMMON_KEYS: Final = ("driver", "bus", "serial", "calibration")
"""What a device's entry says beside its driver's settings."""

_KEYS: Final = ("values", "provenance")


def find_calibration(rig: str, device: str, search: Sequence[Path]) -> tuple[Path, str] | None:
    """Return a device's calibration file and its name from the configuration folder on."""
    name = f"calibration/{rig}/{device}.yaml"
    for configs in search:
        if (configs / name).is_file():
            return configs / name, name
    return None


def read_calibration(path: Path, name: str, problems: Problems) -> tuple[Node, Calibration] | None:
    """Read a calibration file.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        What the resolved profile calls it.
    problems : Problems
        Takes what is wrong with it.

    Returns
    -------
    values : Node
        The mapping to lay over the device's settings.
    calibration : Calibration
        Where they came from.

    Raises
    ------
    ConfigurationError
        The file cannot be read, or is not YAML at all.
    """
    root = parse_mapping(read_source(path), problems)
    assert isinstance(root.value, dict)
    for key, node in root.value.items():
        if key not in _KEYS:
            problems.add(node.heading, f"unknown key {key!r}", nearest(key, _KEYS))
    for key in _KEYS:
        node = root.value.get(key, root)
        if node is root:
            problems.add(root.mark, f"key {key!r} is missing")
        elif not isinstance(node.value, dict) and node.value is not BROKEN:
            problems.add(node.mark, f"{key} is {shown(node.plain())}, expected a mapping")
    values, provenance = root.value.get("values"), root.value.get("provenance")
    if values is None or provenance is None or not isinstance(values.value, dict):
        return None
    for key in COMMON_KEYS:
        if key in values.value:
            problems.add(values.value[key].heading, f"{key} is not a value of a calibration")
    read = read_provenance(provenance, problems)
    return None if read is None else (values, Calibration(name, read))


def read_provenance(node: Node, problems: Problems) -> Provenance | None:
    """Build where a calibration came from."""
    located = with_plain_quantities(node, ("residual_rms", "residual_max"), problems)
    provenance = build(Provenance, located, problems)
    for key in ("date", "valid_until"):
        text: Any = getattr(provenance, key, None)
        if text is not None and not _is_date(text):
            place, _ = node.descend((key,))
            problems.add(place.mark, f"{key} is {shown(text)}, expected a date as in 2026-11-21")
    return provenance


def lay_over(entry: Node, values: Node, calibration: Calibration, problems: Problems) -> Node:
    """Lay calibrated values over a device's entry.

    Each value keeps its place in the calibration file, so that an error points there.
    """
    assert isinstance(entry.value, dict)
    serial = entry.value.get("serial")
    measured = calibration.provenance.serial
    if serial is not None and None not in (serial.value, measured) and serial.value != measured:
        problems.add(
            serial.mark,
            f"the calibration {calibration.file} is of serial number {measured}, "
            f"this device has {shown(serial.plain())}",
            "calibrate this device, or switch it off with calibration: false",
        )
    laid = merge(entry, values)
    # The entry's own place stays: a missing key is the profile's affair.
    return replace(laid, mark=entry.mark, key=entry.key)


def _is_date(text: str) -> bool:
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True
