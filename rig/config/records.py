"""The folders that hold records of a rig: those that count, and those that are not looked in."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from rig.config.laid_over import TUNED
from rig.config.models import Profile
from rig.config.names import find_configs
from rig.config.ownership import is_owner
from rig.config.yaml_loader import read_plain
from rig.hal import ConfigurationError

_COMMISSIONING = "commissioning"


def record_folders(files: Sequence[Path], search: Sequence[Path]) -> list[Path]:
    """Return where calibrations of a profile are looked for, the first that has one wins.

    Parameters
    ----------
    files : sequence of Path
        What was read for the profile, its own file first.
    search : sequence of Path
        The configuration folders. A profile outside of them still finds those beside it.
    """
    own = [file.parent.parent for file in files[:1] if file.parent.name == "rigs"]
    return [*search, *(at for at in own if at not in search)]


def sentences_of_records(profile: Profile, search: Sequence[Path] = ()) -> list[str]:
    """Say which folders near a profile have records of it that are not looked at from here.

    Calibrations, gains and acceptance records are written into `configs` where somebody works:
    who works elsewhere, and names the profile by its path, does not have them.

    Parameters
    ----------
    profile : Profile
        As loaded.
    search : sequence of Path
        The configuration folders; default: the usual ones.
    """
    if not profile.files:
        return []
    parent = profile.files[0].resolve().parent
    used = {at.resolve() for at in record_folders(profile.files, search or find_configs())}
    near = dict.fromkeys([parent, parent / "configs", parent.parent / "configs"])
    return [
        f"{folder} has {', '.join(found)} of this rig, not in force here; use them with: "
        f"cd {folder.parent}"
        for folder in near
        if folder not in used and (found := list(_records_in(folder, profile, used)))
    ]


def _records_in(folder: Path, profile: Profile, used: set[Path]) -> Iterator[str]:
    """Yield what a folder has of a rig that nothing in force here takes the place of."""
    kept = sorted((folder / "calibration" / profile.name).glob("*.yaml"))
    names = [
        path.stem
        for path in kept
        if path.stem not in profile.calibrations and _is_ours(path, profile, folder)
    ]
    laws = [name.removeprefix(TUNED) for name in names if name.startswith(TUNED)]
    others = [name for name in names if not name.startswith(TUNED)]
    if others:
        yield f"calibrations ({', '.join(others)})"
    if laws:
        yield f"gains ({', '.join(laws)})"
    record = f"{_COMMISSIONING}/{profile.name}.yaml"
    is_here = any((at / record).exists() for at in used)
    if not is_here and (folder / record).is_file() and _is_ours(folder / record, profile, folder):
        yield "an acceptance record"


def _is_ours(path: Path, profile: Profile, folder: Path) -> bool:
    """Return whether a record says that it is of this profile; one that is damaged is told, too."""
    try:
        content = read_plain(path)
    except ConfigurationError:
        return True
    found = content if isinstance(content, dict) else {}
    provenance = found.get("provenance")
    label = (provenance if isinstance(provenance, dict) else found).get("profile")
    return not isinstance(label, str) or is_owner(label, profile.files, [folder])
