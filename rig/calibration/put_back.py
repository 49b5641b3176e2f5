"""Kept calibrations put in force again, and the profile's own values."""

import socket
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from rig.calibration.store import HEADER, history, load, put
from rig.config.calibration import HISTORY, find_calibration, seal
from rig.config.plain_dump import dump_plain
from rig.hal import ConfigurationError
from rig.hal.files import reason_unwritten


def restore(
    search: Sequence[Path], rig: str, target: str, date: str, owner: str | None = None
) -> Path:
    """Put a kept calibration in force again; the one before it stays among the kept ones.

    Parameters
    ----------
    search : sequence of Path
        The configuration folders; the file is written into the first.
    rig, target : str
        Whose calibration.
    date : str
        How its time starts, as its file's name has it.
    owner : str, optional
        The profile whose it is from now on, as `owner_label` has it, on this computer: whoever puts
        it in force says so. None: as the kept file says.

    Raises
    ------
    ConfigurationError
        None or several are of that date, or it cannot be written.
    ProfileError
        Its seal does not fit.
    """
    found = [path for path in history(search, rig, target) if path.stem.startswith(date)]
    if len(found) != 1:
        raise ConfigurationError(
            f"{len(found)} calibrations of {target} are of {date}; "
            f"list them with: rig calibrate {rig} --restore {target}"
        )
    content = load(found[0])  # its seal, too
    text = found[0].read_text(encoding="utf-8")
    of, here = content["provenance"], socket.gethostname()
    is_ours = of.get("profile", owner) == owner and of.get("host", here) == here
    if owner is not None and not is_ours:
        said = {"profile": owner, **({"host": here} if "host" in of else {})}
        now = {**content, "provenance": {**of, **said}}
        text = seal(HEADER.format("calibrate --restore") + dump_plain(now))
    path = search[0] / "calibration" / rig / f"{target}.yaml"
    try:
        put(path, text)
    except OSError as error:
        raise ConfigurationError(f"cannot write {path}: {reason_unwritten(path, error)}") from error
    return path


def take_back(search: Sequence[Path], rig: str, target: str) -> Path:
    """Take a calibration out of force, so that the profile's own values are; it stays kept.

    Parameters
    ----------
    search : sequence of Path
        The configuration folders; a file is taken out of the first.
    rig, target : str
        Whose calibration.

    Returns
    -------
    Path
        The file that was in force.

    Raises
    ------
    ConfigurationError
        None is in force, another folder has one that would be then, or it cannot be moved.
    """
    found = [at for at in search if find_calibration(rig, target, [at]) is not None]
    if not found:
        raise ConfigurationError(
            f"no calibration of {target} of the rig {rig} is in force: the profile's own values are"
        )
    if found != [search[0]]:
        other = next(at for at in found if at != search[0])
        raise ConfigurationError(
            f"the calibration of {target} in {other} would be in force: commands write into "
            f"{search[0]} only; work beside {other}, or give it with --configs"
        )
    path = search[0] / "calibration" / rig / f"{target}.yaml"
    kept = path.parent / HISTORY / target / f"{datetime.now(UTC):%Y-%m-%dT%H%M%SZ}.yaml"
    try:
        text = path.read_bytes()
        if all(other.read_bytes() != text for other in history(search, rig, target)):
            kept.parent.mkdir(parents=True, exist_ok=True)
            path.rename(kept)
        else:
            path.unlink()
    except OSError as error:
        raise ConfigurationError(f"cannot move {path}: {reason_unwritten(path, error)}") from error
    return path
