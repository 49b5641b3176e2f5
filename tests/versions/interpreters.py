"""Interpreters of this machine: on the path, of pyenv, and of uv."""

import os
import subprocess
from pathlib import Path

VERSIONS = ("3.11", "3.12", "3.13", "3.14")
"""That the program is to run on; the first is the lowest that it states."""


def find_interpreters() -> dict[str, Path]:
    """Return an interpreter that starts for each version that there is one of."""
    found: dict[str, Path] = {}
    for version in VERSIONS:
        for path in _places(version):
            if _version_of(path) == version:
                found[version] = path
                break
    return found


def _places(version: str) -> list[Path]:
    name = f"python{version}"
    folders = [Path(folder) for folder in os.get_exec_path()]
    home = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    folders += [path / "bin" for path in sorted((home / "versions").glob(f"{version}.*"))]
    of_uv = Path(os.environ.get("UV_PYTHON_INSTALL_DIR", Path.home() / ".local/share/uv/python"))
    folders += [path / "bin" for path in sorted(of_uv.glob(f"cpython-{version}.*"))]
    # A shim of pyenv is a script that may name no version: it does not start, and is passed over.
    return [folder / name for folder in folders if (folder / name).is_file()]


def _version_of(path: Path) -> str | None:
    """Return ``3.x`` of an interpreter that can make environments; None of any other."""
    code = "import sys, ssl, venv; print('%d.%d' % sys.version_info[:2])"
    try:
        done = subprocess.run(
            [path, "-c", code], capture_output=True, text=True, timeout=30, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
