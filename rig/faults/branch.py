"""A process that goes two ways: one does what comes next, the other something else from here on.

A program in virtual time is the same program until something breaks. So the cases of a unit share
the run up to there: at each case's moment the process is copied, and the copy gets a run folder
of its own, with all that was recorded until then.
"""

import os
import shutil
from pathlib import Path
from typing import NamedTuple


class Home(NamedTuple):
    """A folder that a process reaches by an open file, so that its copy can have another.

    Parameters
    ----------
    descriptor : int
        The open folder.
    """

    descriptor: int

    @property
    def path(self) -> Path:
        """The folder, whichever it is in this process."""
        return Path(f"/proc/self/fd/{self.descriptor}")

    def move(self, to: Path) -> None:
        """Copy the folder, and have every open file of this process be its copy's.

        Parameters
        ----------
        to : Path
            Where the copy goes; it must not exist.
        """
        here = self.path.readlink()
        shutil.copytree(here, to)
        for link in list(Path("/proc/self/fd").iterdir()):
            try:
                target = link.readlink()
            except OSError:  # the one that listed them
                continue
            if here in target.parents:
                _replace(int(link.name), to / target.relative_to(here))
        _open_folder(to, self.descriptor)


def make_home(folder: Path) -> Home:
    """Make a folder, and a home of it."""
    folder.mkdir(parents=True)
    return Home(os.open(folder, os.O_RDONLY | os.O_DIRECTORY))


def _open_folder(folder: Path, descriptor: int) -> None:
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    os.dup2(opened, descriptor)
    os.close(opened)


def _replace(descriptor: int, path: Path) -> None:
    """Have a descriptor be another file, opened alike and at the same place."""
    import fcntl

    flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
    opened = os.open(path, flags & (os.O_ACCMODE | os.O_APPEND))
    os.lseek(opened, os.lseek(descriptor, 0, os.SEEK_CUR), os.SEEK_SET)
    os.dup2(opened, descriptor)
    os.close(opened)
