"""Lay what was measured over a profile's document: its own calibrations, and no other rig's."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple

from rig.config.calibration import find_calibration, lay_over, read_calibration
from rig.config.diagnostics import Problems
from rig.config.document import Override, apply_overrides
from rig.config.located import Node
from rig.config.models import Calibration
from rig.config.names import is_name
from rig.config.ownership import is_owner

TUNED: Final = "controllers."
"""Before a law's name in the name of the file that holds the gains that were found for it."""


class Laid(NamedTuple):
    """A document with its calibrations, those of another rig, what was read, who has none."""

    document: Node
    calibrations: dict[str, Calibration]
    foreign: dict[str, Calibration]
    files: list[Path]
    without: list[str]


def lay_calibrations(
    written: Node,
    root: Node,
    rig: str,
    own: Sequence[Path],
    search: Sequence[Path],
    problems: Problems,
) -> Laid:
    """Lay the calibration files over the devices, before any option.

    One that was measured for another profile of the rig's name than the files of its `own` is
    left where it is. Whether a device wants one is read with the options (`root`), where its
    values go without (`written`).
    """
    whole = root.get("calibration")
    refuses_all = whole is not None and whole.value is False
    calibrations: dict[str, Calibration] = {}
    foreign: dict[str, Calibration] = {}
    files: list[Path] = []
    without: list[str] = []
    for name, keys, wanted in _calibratable(root) if rig else ():
        below, taken = written.descend(keys)
        choice = wanted.get("calibration")
        # What a device itself says counts; else what the whole profile refuses.
        wish = choice.value if choice is not None else False if refuses_all else None
        if taken != keys or not isinstance(below.value, dict):
            continue
        if wish is False or isinstance(wish, dict):
            continue  # refused, or already laid over: a resolved profile
        found = find_calibration(rig, name, search)
        if found is None:
            without.append(name)
            if wish is True and choice is not None and not name.startswith(TUNED):
                problems.add(
                    choice.mark,
                    f"{name} has no calibration calibration/{rig}/{name}.yaml",
                    "calibrate it, or go without with calibration: false",
                )
            continue
        read = read_calibration(*found, problems)
        if read is not None and not is_owner(read[1].provenance.profile, own, search):
            foreign[name] = read[1]
            if wish is True and choice is not None and not name.startswith(TUNED):
                problems.add(
                    choice.mark,
                    f"the calibration of {name} belongs to another rig: "
                    f"{read[1].provenance.profile}",
                    "give this profile a name of its own with name:",
                )
            continue
        files.append(found[0])
        if read is not None:
            values, calibration = read
            # Its keys, for now: what stood under them is known when the settings are read.
            calibrations[name] = replace(calibration, replaced=values.plain())
            laid = Override(keys, lay_over(below, values))
            written = apply_overrides(written, [laid], problems)
    return Laid(written, calibrations, foreign, files, without)


def _calibratable(root: Node) -> Iterator[tuple[str, tuple[str, ...], Node]]:
    """Yield what may be calibrated: its name, its keys, and the entry that says if it wants to."""
    devices, mechanism = root.get("devices"), root.get("mechanism")
    if devices is not None and isinstance(devices.value, dict):
        for name, entry in devices.value.items():
            if is_name(name):
                yield name, ("devices", name), entry
    if mechanism is not None and isinstance(mechanism.value, str):
        # The whole profile says whether its mechanism wants one: its section is its settings.
        yield mechanism.value, (mechanism.value,), root
    controllers = root.get("controllers")
    if controllers is not None and isinstance(controllers.value, dict):
        for name in controllers.value:
            if is_name(name):
                yield f"{TUNED}{name}", ("controllers", name), root
