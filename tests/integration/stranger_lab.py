"""A lab with a package of its own: installed beside the program, and its command line."""

import json
import os
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import warm_start

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "tests" / "stranger"
SOURCE = PACKAGE / "src"
PROJECT = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]


class Lab:
    """A folder with the package's configurations, where its commands are run.

    Without a Python of its own it shares this one's modules; they are imported once for all of
    its commands.
    """

    def __init__(self, folder, paths, python=None):
        self.folder = folder
        self.python = python
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(map(str, paths)),
            "MPLBACKEND": "Agg",
            "COLUMNS": "160",
        }

    def python_run(self, *arguments):
        """Run Python and return what came of it."""
        return subprocess.run(
            [self.python or sys.executable, *map(str, arguments)],
            cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=600,
            check=False,
        )  # fmt: skip

    def rig(self, *arguments):
        """Run a command of the program; the folder's `configs` are found by themselves."""
        if self.python is not None:
            return self.python_run("-m", "rig", *arguments)
        return warm_start.run(arguments, folder=self.folder, environment=self.environment)

    def run(self, experiment, *options):
        """Run an experiment and return its run folder."""
        done = self.rig("run", experiment, *options)
        assert done.returncode == 0, done.stderr
        path = done.stderr.split("recording to ")[1].split()[0]
        return self.folder / path


def metrics_of(path):
    """Return the metrics of a run by name."""
    return {m["name"]: m for m in json.loads((path / "metrics.json").read_text())["metrics"]}


def beside_the_source(folder, project=PROJECT, source=SOURCE):
    """Return paths on which a package is as if installed: its source, and what pip would write.

    That is the quick way; the slow one has pip build and install it.
    """
    info = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    sections = (
        f"[{group}]\n" + "".join(f"{name} = {value}\n" for name, value in points.items())
        for group, points in project["entry-points"].items()
    )
    (info / "entry_points.txt").write_text("\n".join(sections))
    return [ROOT, folder, source]


def in_an_environment(folder):
    """Have pip install the package into a new environment that sees this one; return its Python.

    Nothing is fetched: what builds it is `hatchling` of this environment.
    """
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    own = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        capture_output=True, text=True, check=True,
    ).stdout.strip()  # fmt: skip
    around = [path for path in sys.path if path.endswith("site-packages")]
    around += [sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]
    Path(own, "around.pth").write_text("\n".join(dict.fromkeys([str(ROOT), *around])))
    subprocess.run(
        [
            sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-index",
            "--no-deps", "--no-build-isolation", PACKAGE,
        ],
        check=True, env={**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1"},
    )  # fmt: skip
    return python
