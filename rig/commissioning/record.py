"""The record of an acceptance test: a sealed file per rig, and a digest of what was tested."""

import getpass
import hashlib
import json
import os
import socket
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any, Final, NamedTuple, NotRequired, TypedDict, cast

from rig.config import Profile
from rig.config.calibration import HARDWARE, SealWords, check_seal, seal
from rig.config.diagnostics import Problems
from rig.config.dump import plain_of
from rig.config.ownership import is_owner, owner_label
from rig.config.plain_dump import dump_plain
from rig.config.yaml_loader import plain_in, read_plain, read_source
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten
from rig.typed_json import checked
from rig.whole_file import write_whole

FOLDER: Final = "commissioning"
"""Of the configurations, beside rigs and calibrations."""
_LATER: Final = ("simulation", "plant", "controllers", "name", "description")
"""Keys of a profile that say nothing of the hardware, or that are found after the test."""
BY: Final = "operator"
"""Key of a record, for who began it, and of each step, for who has taken that."""
_SEAL: Final = SealWords(
    "rig commission",
    "it was not tested so",
    "take it from a copy, or test again from the first step: rig commission RIG --anew",
)
"""What is said of a record whose seal does not fit; no copy of it is kept."""

Content = dict[str, Any]
"""A record as plain data."""


class _Step(TypedDict, total=False):
    """A step of a record."""

    passed: bool


class _Record(TypedDict):
    """A record, as far as every one is alike."""

    valid_until: str
    backend: str
    settings: str
    digest: str
    steps: dict[str, _Step]
    profile: NotRequired[str]
    seed: NotRequired[int]
    host: NotRequired[str]


_CHANGED: Final = ", of another profile: this one was changed since"
_PROFILE_CHANGED: Final = "its profile was changed since it was commissioned"


class CommissioningState(NamedTuple):
    """The answer to whether a rig may be used as its profile says.

    Parameters
    ----------
    digest : str
        Eight characters over what was tested; empty if nothing was.
    lack : str
        What is missing; empty if nothing is.
    trouble : str
        Why the record cannot be used; empty if it can, or if there is none.
    is_changed : bool
        The profile is another one than was tested.
    """

    digest: str
    lack: str
    trouble: str = ""
    is_changed: bool = False

    @property
    def label(self) -> str:
        """The digest as runs tell it, or nothing."""
        if not self.digest:
            return ""
        return f"commissioning {self.digest}{_CHANGED if self.is_changed else ''}"

    @property
    def whole_lack(self) -> str:
        """All that is missing: a record of another backend may be of another profile, too."""
        is_told = not self.is_changed or self.lack == _PROFILE_CHANGED
        return self.lack if is_told else f"{self.lack}{_CHANGED}"


def tested_settings(profile: Profile) -> str:
    """Return the digest of all of a profile that is tested: what calibrations found is not."""
    plain = plain_of(_uncalibrated(profile))
    kept = {key: value for key, value in plain.items() if key not in _LATER}
    return _digest(kept)


def _uncalibrated(profile: Profile) -> Profile:
    from dataclasses import replace

    devices = {
        name: replace(entry, settings=entry.nominal, calibration=None, uncalibrated=None)
        for name, entry in profile.devices.items()
    }
    return replace(
        profile, devices=devices, mechanism_settings=profile.nominal_settings,
        calibration=None, uncalibrated=None, loop=replace(profile.loop, small_margin=None),
    )  # fmt: skip


def digest_of(settings: str, steps: Content) -> str:
    """Return the eight characters over what was tested; by whom is no part of it.

    Parameters
    ----------
    settings : str
        `tested_settings`.
    steps : mapping
        What each step has found: who the devices are, values and their bounds.
    """
    tested = {
        name: {key: value for key, value in found.items() if key != BY}
        for name, found in steps.items()
    }
    return _digest({"settings": settings, "program": _version(), "steps": tested})[:8]


def _digest(content: object) -> str:
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def _version() -> str:
    return metadata.version("rig-controller")


def record_path(configs: Path, rig: str) -> Path:
    """Return where the record of a rig is."""
    return configs / FOLDER / f"{rig}.yaml"


def load_record(rig: str, search: Sequence[Path]) -> Content | None:
    """Return the record of a rig; None: there is none.

    Raises
    ------
    ConfigurationError
        It was changed by hand, cannot be read, or is no such record.
    """
    for configs in search:
        path = record_path(configs, rig)
        if os.path.lexists(path):  # a pipe or a link to nothing is no missing record
            source = read_source(path)
            problems = Problems()
            check_seal(source, path, problems, _SEAL)
            problems.raise_if_any()
            content = plain_in(source)
            checked(content, _Record, str(path))
            return cast("Content", content)
    return None


def read_answers(path: Path) -> dict[str, str]:
    """Return the answers of a file, by the keys of what is asked.

    Raises
    ------
    ConfigurationError
        It is no mapping of keys to answers.
    """
    content = read_plain(path)
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path} has no keys and answers")
    return {str(key): str(value) for key, value in content.items()}


def operator_of(given: str | None) -> str:
    """Return who tests: who was named, or else the user."""
    return given or getpass.getuser()


def new_record(
    profile: Profile,
    backend: str,
    operator: str | None,
    until: str,
    search: Sequence[Path] = (),
) -> Content:
    """Return a record without any step."""
    owner = owner_label(profile.files, search)
    return {
        "rig": profile.name,
        **({} if owner is None else {"profile": owner}),
        BY: operator_of(operator),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "valid_until": until,
        "backend": backend,
        # Of a simulation: another seed is another unit of the rig.
        **({"seed": profile.simulation.seed} if backend != HARDWARE else {}),
        # Of a real rig: the computer was tested along with it, its wake-ups and its wires.
        **({"host": socket.gethostname()} if backend == HARDWARE else {}),
        "program": _version(),
        "settings": tested_settings(profile),
        "digest": "",
        "steps": {},
    }


def write_record(configs: Path, content: Content) -> Path:
    """Write a record, whole or not at all.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    path = record_path(configs, content["rig"])
    body = dump_plain(content)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, seal("# Written by rig commission; the last line seals it.\n" + body))
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {reason_unwritten(path, error)}") from error
    return path


def whose(profile: Profile, content: Content | None, search: Sequence[Path]) -> str:
    """Return whose a record is, if it is another rig's of the profile's name; else nothing."""
    label = None if content is None else content.get("profile")
    return "" if is_owner(label, profile.files, search) else str(label)


def missing(content: Content, names: Sequence[str]) -> list[str]:
    """Return the steps that a record lacks, in their order."""
    return [name for name in names if not content["steps"].get(name, {}).get("passed")]


def judge(
    profile: Profile, content: Content | None, names: Sequence[str], backend: str
) -> CommissioningState:
    """Return whether a rig was commissioned as it is now, and what is missing.

    Parameters
    ----------
    profile : Profile
        As it is now.
    content : mapping or None
        Its record.
    names : sequence of str
        The steps of its acceptance test.
    backend : str
        On what it is to be used; a record of another one is none.
    """
    if content is None:
        first = f", first of them {names[0]}" if names else ""
        return CommissioningState("", f"it was never commissioned: all steps are missing{first}")
    lacking = missing(content, names)
    if lacking:
        return CommissioningState("", f"its commissioning lacks {', '.join(lacking)}")
    digest, is_changed = content["digest"], content["settings"] != tested_settings(profile)
    if content["backend"] != backend:
        lack = f"it was commissioned on {content['backend']}, not on {backend}"
        return CommissioningState(digest, lack, is_changed=is_changed)
    host, here = content.get("host"), socket.gethostname()
    if host not in (None, here):
        lack = f"it was commissioned with another computer ({host}; this is {here})"
        return CommissioningState(digest, lack, is_changed=is_changed)
    if is_changed:
        return CommissioningState(digest, _PROFILE_CHANGED, is_changed=True)
    if digest != digest_of(content["settings"], content["steps"]):
        return CommissioningState(
            digest, "the program is another version than it was commissioned with"
        )
    if content["valid_until"] < datetime.now(UTC).date().isoformat():
        return CommissioningState(digest, f"its commissioning expired on {content['valid_until']}")
    return CommissioningState(digest, "")
