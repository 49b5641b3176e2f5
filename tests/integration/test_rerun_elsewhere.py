"""`rig rerun` where the program is installed anew: the same bytes from the folder alone."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
from importlib import metadata
from pathlib import Path

import pytest

from rig.cli import invoke
from rig.runtime.log import read_log

ROOT = Path(__file__).parents[2]
PARTS = ("rig", "drivers", "controllers", "configs")


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Return the Python of a new environment with a copy of the program, and our libraries."""
    folder = tmp_path_factory.mktemp("venv")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    ((own,),) = [list(folder.glob("lib/python*/site-packages"))]
    for part in PARTS:
        shutil.copytree(ROOT / part, own / part, ignore=shutil.ignore_patterns("__pycache__"))
    info = own / "rig_controller.dist-info"
    info.mkdir()
    version = metadata.version("rig-controller")
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: rig-controller\nVersion: {version}\n"
    )
    around = dict.fromkeys(sysconfig.get_path(kind) for kind in ("purelib", "platlib"))
    (own / "around.pth").write_text("\n".join(around))
    return folder / "bin" / "python"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("experiment", "options"),
    [("arm-wrist-hit", ["approach=0.5 s"]),
     ("cylinder-step", ["reference.repeats=1", "reference.dwell=0.5 s", "reference.rise=0 s",
                        "reference.size=1 mm"])],
    ids=["arm", "cylinder"],
)  # fmt: skip
def test_a_new_environment_comes_to_the_same_bytes(experiment, options, python, tmp_path):
    out, there = tmp_path / "runs", tmp_path / "there"
    there.mkdir()
    settings = [word for option in options for word in ("--set", option)]
    assert invoke(["run", experiment, "--on", "sim", "--out", str(out), "--no-report",
                   "--seed", "11", *settings]) in (0, 1)  # fmt: skip
    (folder,) = out.iterdir()
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [python, "-m", "rig", "rerun", folder, "--no-report"], cwd=there, env=env,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "every cycle is as it was" in done.stdout, done.stdout + done.stderr
    (again,) = (there / "runs").iterdir()
    manifest = json.loads((again / "manifest.json").read_text())
    assert manifest["machine"]["executable"] == str(python) and manifest["git"] is None
    assert (again / "metrics.json").read_bytes() == (folder / "metrics.json").read_bytes()
    first, second = (read_log(path / "log.mcap") for path in (folder, again))
    kept = [k for k, c in enumerate(first.columns) if not c.name.startswith("timing.")]
    assert first.values[:, kept].tobytes() == second.values[:, kept].tobytes()
