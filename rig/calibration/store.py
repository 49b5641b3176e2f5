"""Calibration files: writing with history, comparing, refusing a worse fit."""

import contextlib
import socket
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple, NotRequired, TypedDict, cast

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.procedure import Evidence, Finding
from rig.calibration.recording import CalibrationRefused
from rig.config import Profile
from rig.config.basis import by_procedure, kept_once
from rig.config.calibration import HARDWARE, HISTORY, UNKNOWN, check_seal, find_calibration, seal
from rig.config.diagnostics import Problems
from rig.config.ownership import owner_label
from rig.config.plain_dump import dump_plain
from rig.config.records import record_folders
from rig.config.yaml_loader import plain_in, read_source
from rig.hal import ConfigurationError
from rig.hal.files import check_writable as check_folder
from rig.hal.files import reason_unwritten
from rig.run_facts import read_manifest
from rig.typed_json import checked
from rig.whole_file import write_whole

HEADER = "# Written by rig {}; the last line seals it. Values of your own go into the profile.\n"
"""First line of a file, by the command that writes it."""

_WORSE = 0.95
"""A fit is worse if chance explains its larger residuals with less than one in twenty."""


Content = Mapping[str, Any]
"""A calibration file as plain data."""


class _Origin(TypedDict):
    """The provenance of a calibration, as far as every one has it."""

    date: str
    operator: str
    procedure: NotRequired[str]
    backend: NotRequired[str]
    residual_rms: NotRequired[float]
    blocks: NotRequired[int]
    profile: NotRequired[str]
    basis: NotRequired[dict[str, dict[str, str]]]


class _Measurement(TypedDict):
    """A quantity that was measured."""

    name: str
    value: float
    std: float
    unit: str
    procedure: str
    backend: NotRequired[str]
    date: NotRequired[str]
    valid_until: NotRequired[str]


class _Dated(TypedDict):
    """A calibration file, as far as every one is alike."""

    provenance: _Origin


class _Kept(_Dated, total=False):
    """A calibration file, as far as it is read back."""

    measured: list[_Measurement]
    values: dict[str, object]
    reasons: dict[str, str]


class Circumstances(NamedTuple):
    """Facts about a calibration that only its operator knows.

    Parameters
    ----------
    operator : str
        Who calibrates.
    valid_for : float
        How long it holds, s.
    conditions : mapping of str to str
        Temperature, supply pressure, instruments, remarks.
    now : datetime
        When.
    backend : str
        On what.
    seed : int or None
        Of the simulation; None on hardware.
    """

    operator: str
    valid_for: float
    conditions: Mapping[str, str]
    now: datetime
    backend: str
    seed: int | None

    @property
    def origin(self) -> str:
        """Where it was measured, for a figure."""
        return HARDWARE if self.backend == HARDWARE else f"simulation ({self.backend})"


def compose(
    finding: Finding,
    procedure: str,
    profile: Profile,
    data: Evidence,
    circumstances: Circumstances,
    old: Content | None,
    search: Sequence[Path] = (),
    basis: Mapping[str, str] | None = None,
) -> Content:
    """Return the content of a calibration file.

    Values that other procedures have found of the same device stay, with their estimates and with
    what they rest on.
    """
    date = circumstances.now.astimezone(UTC).isoformat(timespec="seconds")
    until = circumstances.now + timedelta(seconds=circumstances.valid_for)
    entry = profile.devices.get(finding.target)
    rms, largest = _size(finding.residuals)
    # A value that another procedure had found is replaced with the value itself.
    found = {e.name for e in finding.estimates}
    kept = [
        m
        for m in ([] if old is None else old["measured"])
        if m["procedure"] != procedure and m["name"] not in found
    ]
    before = by_procedure({} if old is None else old["provenance"].get("basis", {}))
    stayed = {m["procedure"] for m in kept}
    provenance = {
        "procedure": procedure,
        "date": date,
        "operator": circumstances.operator,
        "backend": origin_of([circumstances.backend, *(m.get("backend", UNKNOWN) for m in kept)]),
        "seed": circumstances.seed,
        "serial": None if entry is None else entry.serial,
        "host": _host_of(data.paths) if circumstances.backend == HARDWARE else None,
        "profile": owner_label(profile.files, search),
        "samples": data.samples,
        "blocks": finding.blocks,
        "residual_rms": _short(rms),
        "residual_max": _short(largest),
        "residual_bound": finding.bound,
        "unit": finding.unit,
        "valid_until": min(
            [until.date().isoformat(), *(m["valid_until"] for m in kept if "valid_until" in m)]
        ),
        "parent": None if old is None else _name(finding.target, old),
        "software": f"rig-controller {metadata.version('rig-controller')}",
        "log": ", ".join(str(path) for path in data.paths),
        "log_sha256": data.sha256(),
        "conditions": dict(circumstances.conditions),
        "basis": kept_once(
            {**{name: before[name] for name in before if name in stayed}, procedure: basis or {}}
        ),
    }
    measured = [
        {
            "name": e.name,
            "value": _short(e.value, 9),
            "unit": e.unit,
            "std": _short(e.std),
            "interval": [_short(e.low, 9), _short(e.high, 9)],
            "procedure": procedure,
            "backend": circumstances.backend,
            "date": date,
            "valid_until": until.date().isoformat(),
        }
        for e in finding.estimates
    ]
    values = _merged({} if old is None else old["values"], finding.values)
    reasons = {**({} if old is None else old.get("reasons", {})), **finding.reasons}
    return {
        "values": values,
        **({"reasons": reasons} if reasons else {}),
        "measured": [*kept, *measured],
        "provenance": {key: value for key, value in provenance.items() if value is not None},
    }


def _host_of(logs: Sequence[Path]) -> str:
    """Return the computer that recorded some logs; of none that tells, this one."""
    for log in logs:
        with contextlib.suppress(ConfigurationError):
            host = read_manifest(log.parent).get("machine", {}).get("host")
            if isinstance(host, str):
                return host
    return socket.gethostname()


def origin_of(backends: Sequence[str]) -> str:
    """Return where values were measured: not on hardware, if one of them was not."""
    return next((backend for backend in backends if backend != HARDWARE), HARDWARE)


def check_not_worse(finding: Finding, procedure: str, old: Content | None) -> None:
    """Refuse a fit that is worse than the one in force, and one that is bad in itself.

    Raises
    ------
    CalibrationRefused
        With both residuals.
    """
    from scipy.stats import f

    rms, _ = _size(finding.residuals)
    if rms > finding.bound:
        raise CalibrationRefused(
            f"{finding.target}: the residual is {rms:.4g} {finding.unit} rms, above the bound of "
            f"{finding.bound:.4g} {finding.unit}: this fit does not describe the device"
        )
    if old is None or old["provenance"].get("procedure") != procedure:
        return
    # One that does not say how well it fitted is worse than none that does.
    was, blocks = old["provenance"].get("residual_rms", rms), old["provenance"].get("blocks", 2)
    chance = f.ppf(_WORSE, max(finding.blocks - 1, 1), max(blocks - 1, 1))
    if rms > 0.0 and rms**2 > chance * was**2:
        raise CalibrationRefused(
            f"{finding.target}: the residual is {rms:.4g} {finding.unit} rms, that of the "
            f"calibration in force {was:.4g}: a worse fit does not replace a better one unless "
            "it is told to (--replace)"
        )


def check_ours(profile: Profile, targets: Sequence[str]) -> None:
    """Refuse to write over calibrations that are another rig's of the same name.

    Raises
    ------
    CalibrationRefused
        With that rig's profile.
    """
    for target in targets:
        if target in profile.foreign:
            raise CalibrationRefused(
                f"{target}: the calibration {profile.foreign[target].file} belongs to another "
                f"rig: {profile.foreign[target].provenance.profile}; give this profile a name of "
                "its own with name: NAME, or write over it with --replace"
            )


def write(
    configs: Path, rig: str, target: str, content: Content, command: str = "calibrate"
) -> Path:
    """Write a calibration file of a command and its copy in the history, whole or not at all.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    path = configs / "calibration" / rig / f"{target}.yaml"
    body = dump_plain(content)
    text = seal(HEADER.format(command) + body)
    stamp = content["provenance"]["date"].replace(":", "").replace("+0000", "Z")
    kept = path.parent / HISTORY / target / f"{stamp}.yaml"
    try:
        suffix = 1
        while kept.exists():
            suffix += 1
            kept = kept.with_name(f"{stamp}-{suffix}.yaml")
        for place in (kept, path):  # the copy first: the old file is in force until all is kept
            put(place, text)
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {reason_unwritten(path, error)}") from error
    return path


def check_writable(configs: Path, rig: str) -> None:
    """Find out whether calibrations of a rig can be kept, before anything moves for them.

    Raises
    ------
    ConfigurationError
        They could not be written.
    """
    folder = configs / "calibration" / rig
    for place in (folder / HISTORY, folder):
        check_folder(place, f"calibrations of {rig}")


def load(path: Path) -> Content:
    """Read a calibration file as plain data.

    Raises
    ------
    ProfileError
        Its seal does not fit, with line and column.
    ConfigurationError
        It cannot be read.
    """
    source = read_source(path)
    problems = Problems()
    check_seal(source, path, problems)
    problems.raise_if_any()
    content = plain_in(source)
    checked(content, _Kept, str(path))
    return {"measured": [], "values": {}, **cast("Content", content)}


def find(search: Sequence[Path], rig: str, name: str) -> Path:
    """Return a calibration file by its path, its device, or its path in the rig's folder.

    Raises
    ------
    ConfigurationError
        There is none.
    """
    places = [Path(name)]
    for configs in search:
        folder = configs / "calibration" / rig
        places += [folder / name, folder / f"{name}.yaml", folder / HISTORY / f"{name}.yaml"]
    for place in places:
        if place.is_file():
            return place
    raise ConfigurationError(f"no calibration of the rig {rig} is called {name!r}")


def put(path: Path, text: str) -> None:
    """Write a file whole, and the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)


def in_force(profile: Profile, search: Sequence[Path], target: str) -> Content | None:
    """Return the calibration that is in force, None without one or with another rig's."""
    found = find_calibration(profile.name, target, record_folders(profile.files, search))
    return None if found is None or target in profile.foreign else load(found[0])


def history(search: Sequence[Path], rig: str, target: str) -> list[Path]:
    """Return every calibration of a device that is kept, oldest first."""
    found: list[Path] = []
    for configs in search:
        found += (configs / "calibration" / rig / HISTORY / target).glob("*.yaml")
    return sorted(found, key=lambda path: path.name)


def kept_targets(search: Sequence[Path], rig: str) -> list[str]:
    """Return everything of a rig of which calibrations are in force or kept."""
    folders = [configs / "calibration" / rig for configs in search]
    in_force = [path.stem for folder in folders for path in folder.glob("*.yaml")]
    kept = [path.name for folder in folders for path in (folder / HISTORY).glob("*/")]
    return [*in_force, *kept]


def _name(target: str, content: Content) -> str:
    stamp = str(content["provenance"]["date"]).replace(":", "").replace("+0000", "Z")
    return f"{HISTORY}/{target}/{stamp}.yaml"


def _merged(old: Any, new: Any) -> Any:
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        keys = [*old, *(key for key in new if key not in old)]
        return {key: _merged(old.get(key), new[key]) if key in new else old[key] for key in keys}
    return (
        {key: _merged(None, value) for key, value in new.items()}
        if isinstance(new, Mapping)
        else new
    )


def _size(residuals: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(residuals**2))), float(np.abs(residuals).max())


def _short(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")
