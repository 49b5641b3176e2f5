"""What rigs and experiments say that they are, kept: to read every file takes most of `rig list`.

A file is read anew when its size, its time or its place on the disk is another one. What is kept is
the user's own, is only shown, and may be thrown away.
"""

import contextlib
import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypedDict

from rig.hal.errors import ConfigurationError
from rig.hal.files import read_regular, users_folder
from rig.whole_file import write_whole

if TYPE_CHECKING:
    from rig.config.located import Plain

_MOST: Final = 1000
"""Files whose descriptions are kept."""
_LONGEST: Final = 10_000_000
"""Bytes that these may take; a longer store is none of ours."""
_FRESH: Final = 2_000_000_000
"""A file that was written so few ns ago may be written again within the same tick of its time."""


class _Kept(TypedDict):
    seen: list[int]
    text: str


def descriptions_of(paths: Iterable[Path]) -> dict[Path, str]:
    """Return what each file says that it is, or that it cannot be read."""
    store = users_folder("XDG_CACHE_HOME", ".cache") / "rig" / "descriptions.json"
    kept = _kept_in(store)
    found: dict[Path, str] = {}
    fresh: dict[str, _Kept] = {}
    for path in paths:
        seen, name = _seen(path), str(path.absolute())
        if name in kept and kept[name]["seen"] == seen:
            found[path] = kept[name]["text"]
            continue
        text = _read(path)
        found[path] = f"cannot be read; see `rig check {path}`" if text is None else text
        if text is not None and seen and time.time_ns() - seen[0] > _FRESH:
            fresh[name] = {"seen": seen, "text": text}
    if fresh:
        _keep(store, fresh | {name: known for name, known in kept.items() if name not in fresh})
    return found


def _seen(path: Path) -> list[int]:
    try:
        status = path.stat()
    except OSError:
        return []
    return [status.st_mtime_ns, status.st_size, status.st_ino, status.st_dev]


def _read(path: Path) -> str | None:
    from rig.config.yaml_loader import read_plain  # slow to import

    try:
        content: Plain = read_plain(path)
    except ConfigurationError:
        return None
    text = content.get("description", "") if isinstance(content, dict) else ""
    return " ".join(str(text).split())


def _kept_in(store: Path) -> dict[str, _Kept]:
    """Return what is kept, without whatever is none of it."""
    try:
        content = json.loads(read_regular(store, _LONGEST))
    except (ConfigurationError, ValueError, RecursionError):
        return {}
    if not isinstance(content, dict):
        return {}
    return {
        name: {"seen": kept["seen"], "text": kept["text"]}
        for name, kept in content.items()
        if isinstance(kept, dict)
        and isinstance(kept.get("text"), str)
        and isinstance(kept.get("seen"), list)
    }


def _keep(store: Path, content: dict[str, _Kept]) -> None:
    newest = dict(list(content.items())[:_MOST])
    with contextlib.suppress(OSError):
        store.parent.mkdir(parents=True, exist_ok=True)
        write_whole(store, json.dumps(newest))
