"""The origin of a run: checkout, versions, machine and input files."""

import hashlib
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from pathlib import Path

from rig.run_facts import GitState

PACKAGES = (
    "rig-controller",
    "canopen",
    "filterpy",
    "matplotlib",
    "mcap",
    "mujoco",
    "numba",
    "numpy",
    "python-can",
    "scipy",
)
"""Packages whose version may change a result."""

_GIT_TIMEOUT = 2.0
"""A checkout on a slow network drive must not hold up a run, s."""


_OURS = ("rig", "drivers", "controllers", "configs")
"""Folders of a checkout in which a file that git does not know may shape a run: a new profile."""


def git_state(directory: Path | None = None) -> GitState | None:
    """Return commit and dirty flag of the checkout that this program runs from.

    Parameters
    ----------
    directory : Path, optional
        Where to look; default: where this package is.

    Returns
    -------
    GitState or None
        None when it is not a checkout or git is missing.
    """
    directory = Path(__file__).resolve().parent if directory is None else directory
    # Without this, a package installed inside some other project would report that project.
    if not any((parent / ".git").exists() for parent in (directory, directory.parent)):
        return None
    try:
        commit = _git(directory, "rev-parse", "HEAD")
        changed = _git(directory, "status", "--porcelain", "--untracked-files=no")
        root = Path(_git(directory, "rev-parse", "--show-toplevel"))
        untracked = _git(root, "ls-files", "--others", "--exclude-standard", "--", *_OURS)
        dirty = changed + untracked != ""
    except (OSError, subprocess.SubprocessError):
        return None
    return {"commit": commit, "dirty": dirty}


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that may change a result."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return found


def machine() -> dict[str, object]:
    """Return host name, platform and processor count."""
    return {
        "host": socket.gethostname(),
        "platform": platform.platform(),
        "processors": os.cpu_count(),
        "executable": sys.executable,
    }


def file_hashes(files: Mapping[str, str | bytes]) -> dict[str, str]:
    """Return the SHA-256 of each text, as hexadecimal digits, by name."""
    return {
        name: hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()
        for name, content in files.items()
    }


def _git(directory: Path, *arguments: str) -> str:
    # GIT_OPTIONAL_LOCKS=0: looking at a checkout must not disturb who works in it.
    return subprocess.run(
        ["git", *arguments],
        cwd=directory,
        env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        capture_output=True,
        check=True,
        text=True,
        timeout=_GIT_TIMEOUT,
    ).stdout.strip()
