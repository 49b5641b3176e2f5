"""What the files of a run folder must be like to be read: somebody may have edited them."""

from collections.abc import Mapping, Sequence
from types import NoneType, UnionType
from typing import Final

FORMAT: Final = 1
"""Of run folders. A manifest that does not say it is of the first."""

_FACTS: Final[Mapping[str, type | UnionType]] = {
    "format": int, "experiment": str, "backend": str, "rig": str, "law": str, "command": list,
    "seed": int | None, "started": str, "ended": str | None, "exit_code": int | None,
    "message": str | None, "git": dict | None, "versions": dict, "machine": dict, "files": dict,
}  # fmt: skip


def trouble_with_manifest(manifest: object, statuses: Sequence[str]) -> str | None:
    """Say what in a manifest cannot be; None if all of it can."""
    if not isinstance(manifest, dict):
        return "its manifest.json holds no facts"
    said = manifest.get("format", FORMAT)
    if isinstance(said, int) and said > FORMAT:
        versions = manifest.get("versions")
        version = versions.get("rig-controller") if isinstance(versions, dict) else None
        return (
            f"rig {version or 'of a later version'} recorded it in format {said}, and this version "
            f"reads formats up to {FORMAT}"
        )
    if manifest.get("status") not in statuses:
        return "its manifest.json has no status that a run can have"
    for name, kind in _FACTS.items():
        if name in manifest and not isinstance(manifest[name], kind):
            return f"its manifest.json has {manifest[name]!r} for {name}"
    git = manifest.get("git")
    if isinstance(git, dict) and not {"commit", "dirty"} <= set(git):
        return f"its manifest.json has {git!r} for git"
    return None


def is_metric(row: object) -> bool:
    """Return whether an entry of ``metrics.json`` has a name, and a number or nothing for value."""
    return (
        isinstance(row, dict)
        and isinstance(row.get("name"), str)
        and "value" in row
        and isinstance(row["value"], int | float | NoneType)
        and isinstance(row.get("unit", ""), str)
    )
