"""The cameras that the operating system shows."""

from pathlib import Path
from typing import NamedTuple


class SeenCamera(NamedTuple):
    """A camera of the operating system.

    Parameters
    ----------
    path : str
        By which it is opened; a name that stays the same wherever it is plugged in, if it has one.
    name : str
        What it calls itself.
    """

    path: str
    name: str


def seen_cameras(root: Path = Path("/")) -> list[SeenCamera]:
    """Return the cameras below a root of the file system, in the order of their numbers.

    A camera has further nodes for its metadata, which show no image; they are left out.
    """
    found: list[SeenCamera] = []
    folders = list((root / "sys/class/video4linux").glob("video*"))
    for folder in sorted(folders, key=lambda folder: (len(folder.name), folder.name)):
        if _line(folder / "index") in ("", "0"):
            found.append(SeenCamera(_path(root, folder.name), _line(folder / "name")))
    return found


def _line(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def _path(root: Path, node: str) -> str:
    links = sorted((root / "dev/v4l/by-id").glob("*"))
    named = next((link for link in links if link.resolve().name == node), None)
    return f"/dev/{node}" if named is None else f"/dev/v4l/by-id/{named.name}"
