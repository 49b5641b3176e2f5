"""Calibration files: measured values of one device, laid over its settings in the profile.

``calibration/<rig>/<device>.yaml`` holds ``values``, in the words of the device's settings (or of
the mechanism's, in a file of its name), ``reasons`` where one is not what was estimated, what was
``measured`` with its uncertainty, and its ``provenance``. The profile stays as it was written; what
was laid over it stands in the resolved profile of every run. The last line seals what stands above
it: a value that somebody changed by hand was not measured.
"""

import hashlib
import os
import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Final, NamedTuple

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.document import merge, parse_mapping, with_plain_quantities
from rig.config.located import BROKEN, Mark, Node, Plain, Source
from rig.config.models import Calibration, Provenance
from rig.config.settings import build
from rig.config.yaml_loader import read_source
from rig.hal import ConfigurationError

COMMON_KEYS: Final = ("driver", "bus", "serial", "calibration")
"""What a device's entry says beside its driver's settings."""

STATED: Final = "profile"
"""Backend of gains that rest on what a profile states, and on no measurement."""

HISTORY: Final = "history"
"""Folder beside a rig's calibrations that keeps every one that was ever written."""

HARDWARE: Final = "hardware"
UNKNOWN: Final = "unknown"
"""Where a value was measured: on the rig itself; nobody has written it down."""

_KEYS: Final = ("values", "provenance")
_OTHER_KEYS: Final = ("reasons", "measured", "seal")

_SEAL: Final = re.compile(r"^seal: ([0-9a-f]{64})\n?\Z", re.MULTILINE)


def seal(text: str) -> str:
    """Return the text of a calibration file with its seal as the last line.

    Parameters
    ----------
    text : str
        Everything above; a seal that it has is replaced.
    """
    body = _SEAL.sub("", text)
    body = body if body.endswith("\n") else body + "\n"
    return f"{body}seal: {hashlib.sha256(body.encode()).hexdigest()}\n"


class SealWords(NamedTuple):
    """The words on a file whose seal does not fit.

    Parameters
    ----------
    writer : str
        The command that writes it.
    changed : str
        What is so if somebody changed it.
    mend : str
        What mends both.
    """

    writer: str
    changed: str
    mend: str


def check_seal(
    source: Source, path: Path, problems: Problems, words: SealWords | None = None
) -> None:
    """Note where a file was changed after it was written, or that it is cut short.

    Parameters
    ----------
    source : Source
        Its text.
    path : Path
        Where it is.
    problems : Problems
        Takes what is wrong.
    words : SealWords, optional
        Of another file than a calibration.
    """
    kept = path.parent / HISTORY / path.stem
    writer, changed, mend = words or SealWords(
        "rig calibrate",
        "what stands here was not measured",
        "calibrate again; a value of your own belongs into the profile or --set",
    )
    found = _SEAL.search(source.text)
    if found is None:
        end = source.mark_at(len(source.text.rstrip("\n")))
        problems.add(
            end,
            f"the file ends without its seal: it is truncated, or was not written by {writer}",
            mend if words else f"calibrate again, or take the last one of {kept}",
        )
        return
    body = source.text[: found.start()]
    if hashlib.sha256(body.encode()).hexdigest() == found[1]:
        return
    mark, was = _changed_at(source, path, found)
    problems.add(
        mark,
        f"the file was changed after it was written: {changed}",
        was or mend,
    )


def _changed_at(source: Source, path: Path, found: re.Match[str]) -> tuple[Mark, str | None]:
    """Return the first place that differs from the kept copy, and what stood there."""
    for kept in sorted((path.parent / HISTORY / path.stem).glob("*.yaml")):
        try:
            original = read_source(kept).text
        except ConfigurationError:
            continue
        text = source.text
        # A copy that was changed alike, with all of a folder, says nothing of what stood there.
        if original != text and original.endswith(found[0].rstrip("\n") + "\n"):
            offset = next(
                (i for i, (a, b) in enumerate(zip(text, original, strict=False)) if a != b),
                min(len(text), len(original)),
            )
            line = original[:offset].count("\n")
            return source.mark_at(offset), f"it was: {original.splitlines()[line].strip()}"
    return source.mark_at(found.start()), None


def find_calibration(rig: str, device: str, search: Sequence[Path]) -> tuple[Path, str] | None:
    """Return a device's calibration file and its name from the configuration folder on."""
    name = f"calibration/{rig}/{device}.yaml"
    for configs in search:
        # A pipe or a link to nothing in its place is no missing file: whoever reads it says so.
        if os.path.lexists(configs / name):
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
    source = read_source(path)
    sealed = Problems()
    check_seal(source, path, sealed)
    sealed.raise_if_any()
    root = parse_mapping(source, problems)
    assert isinstance(root.value, dict)
    for key, node in root.value.items():
        if key not in (*_KEYS, *_OTHER_KEYS):
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
    if read is None:
        return None
    measured = root.value.get("measured")
    known = deviations(None if measured is None else measured.plain())
    return values, Calibration(name, read, deviations=known)


def deviations(measured: Plain) -> dict[str, float]:
    """Return the standard deviations that the ``measured`` of a calibration file tells."""
    rows = measured if isinstance(measured, list) else []
    found = {}
    for row in rows:
        name, std = (row.get("name"), row.get("std")) if isinstance(row, dict) else (None, None)
        if isinstance(name, str) and isinstance(std, int | float):
            found[name] = float(std)
    return found


def read_provenance(node: Node, problems: Problems) -> Provenance | None:
    """Build where a calibration came from."""
    residuals = ("residual_rms", "residual_max", "residual_bound")
    located = with_plain_quantities(node, residuals, problems)
    provenance = build(Provenance, located, problems)
    if provenance is not None:
        for key, text in (("date", provenance.date), ("valid_until", provenance.valid_until)):
            if text is not None and not _is_date(text):
                mark = node.descend((key,))[0].mark
                problems.add(mark, f"{key} is {shown(text)}, expected a date as in 2026-11-21")
    return provenance


def lay_over(entry: Node, values: Node) -> Node:
    """Lay calibrated values over a device's entry or a mechanism's section.

    Each value keeps its place in the calibration file, so that an error points there.
    """
    laid = merge(entry, values)
    # The entry's own place stays: a missing key is the profile's affair.
    return replace(laid, mark=entry.mark, key=entry.key)


def with_replaced(entry: Node, calibration: Calibration) -> Node:
    """Return an entry of a resolved profile as it was before it was calibrated."""

    def located(content: Plain) -> Node:
        if isinstance(content, dict):
            below = {key: located(value) for key, value in content.items()}
            return Node(below, entry.mark, entry.key)
        if isinstance(content, list):
            return Node([located(value) for value in content], entry.mark, entry.key)
        return Node(content, entry.mark, entry.key)

    return merge(entry, located(calibration.replaced))


def pruned(content: Plain, like: Plain) -> Plain:
    """Return of a plain value what stands under the keys of another one."""
    if isinstance(content, dict) and isinstance(like, dict):
        return {key: pruned(content.get(key), below) for key, below in like.items()}
    return content


def _is_date(text: str) -> bool:
    try:
        datetime.fromisoformat(text)
    except ValueError:
        return False
    return True
