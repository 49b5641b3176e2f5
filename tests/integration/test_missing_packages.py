"""A package that is not installed is a sentence with what installs it, and no bug of ours."""

import ast
import os
import shlex
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rig.installation import BENEATH, PACKAGES, installing, missing_package, need

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
WITHOUT = """
import os, sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == os.environ["WITHOUT"]:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
"""
EXTRAS = ("dask", "gamepad", "multicast", "parquet", "watch")
"""Of ours, that bring what a user may lack."""
RUN = ("run", "cylinder-step", "--no-report", "--out", "runs")
SIMULATED = (*RUN, "--on", "sim")
CASES = [
    ("click", "click", SIMULATED),
    ("numpy", "numpy", SIMULATED),
    ("yaml", "pyyaml", SIMULATED),
    ("pydantic", "pydantic", SIMULATED),
    ("annotated_types", "annotated-types", SIMULATED),
    ("numba", "numba", SIMULATED),
    ("canopen", "canopen", RUN),
    ("can", "python-can", RUN),
    ("cv2", "opencv-python-headless", ("run", "joint-circle", "--no-report", "--out", "runs")),
    ("mujoco", "mujoco", ("run", "arm-elbow-circle", "--on", "sim", "--out", "runs")),
    ("mujoco", "mujoco", ("run", "legs-squat", "--on", "sim", "--out", "runs")),
    ("cma", "cma", ("tune", "cylinder", "--dry-run", "--out", "runs")),
    ("matplotlib", "matplotlib", ("report", "RUN")),
    ("scipy", "scipy", ("export", "RUN", "--format", "mat")),
]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return a run that has ended well."""
    out = tmp_path_factory.mktemp("done")
    subprocess.run(
        [sys.executable, "-m", "rig", *SIMULATED, "--out", out], check=True, capture_output=True
    )
    return next(out.iterdir())


def rig_without(name, folder, *words):
    """Run a command where a package is not to be found."""
    (folder / "sitecustomize.py").write_text(WITHOUT)
    return subprocess.run(
        [sys.executable, "-m", "rig", *words],
        cwd=folder, env={**os.environ, "PYTHONPATH": f"{folder}:{ROOT}", "WITHOUT": name},
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip


@pytest.mark.parametrize(("name", "package", "words"), CASES)
def test_the_package_is_named_with_what_installs_it(tmp_path, done, name, package, words):
    told = rig_without(name, tmp_path, *(str(done) if word == "RUN" else word for word in words))
    assert told.returncode == 2, told.stderr
    last = told.stderr.splitlines()[-1]
    assert last.startswith("error: ")
    assert last.endswith(f"{name} is not installed here: pip install {package}")
    assert "Traceback" not in told.stderr and "bug" not in told.stderr
    for manifest in tmp_path.glob("runs/*/manifest.json"):
        assert '"exit_code": 2' in manifest.read_text()


@pytest.mark.parametrize(
    ("name", "experiment"), [("numba", "cylinder-step"), ("mujoco", "legs-squat")]
)
def test_a_sweep_whose_workers_lack_it_ends_and_finds_nothing_of_a_point(
    tmp_path, name, experiment
):
    told = rig_without(
        name, tmp_path, "sweep", experiment, "--seeds", "0:2", "--on", "sim", "--out", "sweep"
    )
    assert told.returncode == 3, told.stderr
    last = told.stderr.splitlines()[-1]
    assert last == f"error: sweep: {name} is not installed here: pip install {name}"
    assert (tmp_path / "sweep" / "points.jsonl").read_text().count('"status"') == 0


BEFORE = [
    ("matplotlib", ("run", "cylinder-step", "--on", "sim", "--out", "runs")),
    ("matplotlib", ("compare", "cylinder-step", "--controllers", "cascade,pid", "--out", "runs")),
    ("matplotlib", ("sweep", "cylinder-step", "--seeds", "0:2", "--on", "sim", "--out", "runs/s")),
    ("matplotlib", ("calibrate", "cylinder", "wires", "--on", "sim", "--yes", "--out", "runs")),
    ("matplotlib", ("tune", "cylinder", "--dry-run", "--out", "runs")),
    ("scipy", ("calibrate", "cylinder", "wires", "--on", "sim", "--yes", "--out", "runs")),
]


@pytest.mark.parametrize(("name", "words"), BEFORE, ids=[f"{n} {w[0]}" for n, w in BEFORE])
def test_what_draws_and_fits_is_missed_before_anything_moves(tmp_path, name, words):
    told = rig_without(name, tmp_path, *words)
    assert told.returncode == 2
    assert told.stderr.endswith(f"error: {name} is not installed here: pip install {name}\n")
    assert "Traceback" not in told.stderr and "Warning" not in told.stderr
    assert not list(tmp_path.rglob("log.mcap"))


UNDER = [
    ("kiwisolver", "matplotlib", ("run", "cylinder-step", "--on", "sim", "--out", "runs")),
    ("cycler", "matplotlib", BEFORE[1][1]),
    ("dateutil", "matplotlib", BEFORE[2][1]),
    ("PIL", "matplotlib", ("report", "RUN")),
    ("llvmlite", "numba", SIMULATED),
    ("typing_extensions", "pydantic", ("check", "cylinder")),
]


@pytest.mark.parametrize(("name", "above", "words"), UNDER)
def test_what_one_of_these_needs_is_told_with_it(tmp_path, done, name, above, words):
    told = rig_without(name, tmp_path, *(str(done) if word == "RUN" else word for word in words))
    assert told.returncode == 2, told.stderr
    assert told.stderr.splitlines()[-1] == (
        f"error: {name}, which {above} needs, is not installed here: pip install {above}"
    )
    assert "Traceback" not in told.stderr
    assert not list(tmp_path.rglob("log.mcap"))


def test_only_what_the_installed_version_requires_is_missed(monkeypatch):
    """A version to come may do without one of these."""
    monkeypatch.setattr("rig.installation.find_spec", lambda name: name == "matplotlib" or None)
    with pytest.raises(ModuleNotFoundError) as missed:
        need("matplotlib")
    assert missed.value.name in BENEATH
    wanted = ["numpy>=1.25", "python-dateutil-next", "pillow; extra == 'dev'"]
    monkeypatch.setattr("rig.installation.requires", lambda name: wanted)
    need("matplotlib")
    wanted.append("Pillow>=9")
    with pytest.raises(ModuleNotFoundError, match="PIL"):
        need("matplotlib")


@pytest.mark.parametrize(("source", "is_told"), [("arm-wrist-hit", True), ("cylinder", False)])
def test_what_cannot_be_simulated_here_is_valid_with_a_warning(tmp_path, source, is_told):
    told = rig_without("mujoco", tmp_path, "check", source)
    assert told.returncode == 0
    warned = [line for line in told.stderr.splitlines() if "cannot be simulated" in line]
    assert [line.startswith("warning: ") for line in warned] == [True] * is_told
    assert all("mujoco is not installed here: pip install mujoco" in line for line in warned)


def test_pip_knows_every_package_by_that_name():
    extras = PROJECT["optional-dependencies"]
    for package in PACKAGES.values():
        wanted = Requirement(package.strip("'"))
        texts = [*PROJECT["dependencies"]]
        texts += (text for name in EXTRAS for text in extras[name])
        assert any(
            wanted.name == (one := Requirement(text)).name and wanted.extras <= one.extras
            for text in texts
        )


@pytest.mark.parametrize("name", ["aiohttp", "distributed", "evdev", "pyarrow"])
def test_an_extra_is_installed_as_the_pages_install(name, monkeypatch, tmp_path):
    pip, install, option, what = shlex.split(installing(name))
    assert (pip, install, option) == ("pip", "install", "-e")
    folder, _, extra = what.removesuffix("]").partition("[")
    assert Path(folder) == ROOT and extra in EXTRAS
    texts = PROJECT["optional-dependencies"][extra]
    assert name in {Requirement(text).name for text in texts}
    told = missing_package(ModuleNotFoundError(f"No module named {name!r}", name=name))
    assert told == f"{name} is not installed here: {installing(name)}"
    monkeypatch.setattr("rig.installation._CLONE", tmp_path)  # no clone: ours is on no index
    assert installing(name) == f"pip install {name}"


def test_every_package_that_is_needed_is_known():
    needed = {canonicalize_name(Requirement(text).name) for text in PROJECT["dependencies"]}
    assert needed <= set(PACKAGES.values())


def test_every_package_beneath_those_is_known():
    known, wanted = packages_distributions(), {*PROJECT["dependencies"]}
    seen = set()
    while wanted:
        one = Requirement(wanted.pop())
        if one.name not in seen and (one.marker is None or one.marker.evaluate({"extra": ""})):
            seen.add(one.name)
            wanted |= set(requires(one.name) or ())
    seen = {canonicalize_name(name) for name in seen}
    modules = {module for module, of in known.items() if seen & {*map(canonicalize_name, of)}}
    tops = {module for module in modules if module.isidentifier() and not module.startswith("_")}
    assert tops - {"pylab", "mpl_toolkits"} <= PACKAGES.keys() | BENEATH.keys()
    assert set(BENEATH.values()) <= PACKAGES.keys()


def test_every_module_of_others_that_is_imported_is_known():
    """By what the sources say; the rest comes with one of these, or is for who tests a rig."""
    said = set()
    for folder in ("rig", "drivers", "controllers"):
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Import):
                    said |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom):
                    said.add(str(node.module).partition(".")[0])
    ours = {"rig", "drivers", "controllers", "configs"}
    with_others = {"pydantic_core", "typing_extensions", "_typeshed", "pandas", "pytest"}
    assert said - sys.stdlib_module_names - ours - with_others <= PACKAGES.keys()
    assert {"mujoco", "cv2", "serial", "cma", "numba"} <= said


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'rig.nothing'", name="rig.nothing"),
        ModuleNotFoundError("No module named 'drivers'", name="drivers"),
        ModuleNotFoundError("No module named 'numpy._core'", name="numpy._core"),
        ModuleNotFoundError("No module named 'theirs'", name="theirs"),
        ModuleNotFoundError("No module named 'numpy'"),
        ImportError("cannot import name 'x' from 'numpy'", name="numpy"),
        ValueError("numpy"),
    ],
)
def test_what_is_no_missing_package_is_as_it_was(error):
    assert missing_package(error) is None
