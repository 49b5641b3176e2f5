"""What the run's cameras see, as long as somebody looks on."""

from pathlib import Path

from rig.hal.pictures import SUFFIX, PictureFile
from rig.watching.messages import pack_picture

MOST = 4
"""Cameras that are shown."""
_JPEG = b"\xff\xd8\xff"


class Cameras:
    """Asks for pictures and takes them out of the run's folder; of a run that goes on.

    Parameters
    ----------
    folder : Path
        The run's.

    Attributes
    ----------
    names : tuple of str
        Of the cameras that have been found.
    last : dict
        The newest picture of each, packed, by its number: also after the run has ended.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: dict[int, PictureFile] = {}
        self.names: tuple[str, ...] = ()
        self.last: dict[int, bytes] = {}

    def find(self) -> bool:
        """Look for cameras, unless some have been found; return whether there are new ones."""
        if self.names:
            return False
        found: list[str] = []
        for path in sorted(self._folder.glob(f"*{SUFFIX}"))[:MOST]:
            try:
                self._files[len(found)] = PictureFile(path)
            except (OSError, ValueError):
                continue  # it is somebody else's, or something else
            found.append(path.name.removesuffix(SUFFIX))
        self.names = tuple(found)
        return bool(found)

    def look(self) -> tuple[bytes, ...]:
        """Ask for pictures; return those that are new, packed."""
        fresh = {}
        for number, file in list(self._files.items()):
            try:
                file.ask()
                picture = file.newest()
            except OSError:
                self._files.pop(number).close()  # no room for pictures: the page goes on
                continue
            if picture is not None and picture.jpeg.startswith(_JPEG):
                fresh[number] = pack_picture(number, picture)
        self.last |= fresh
        return tuple(fresh.values())

    def close(self) -> None:
        """Let go of the files."""
        for file in self._files.values():
            file.close()
        self._files.clear()
