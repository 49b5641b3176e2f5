"""What the READMEs say that one more of anything takes is what it took a package to do it."""

import re

import pytest
from stranger_lab import ROOT, SOURCE

from rig.hal.parts import Additions, DriverParts, MechanismParts

README = (ROOT / "rig" / "README.md").read_text()
PACKAGE = SOURCE / "crank_rig"
ROWS = {
    name.strip(): (int(files), int(concepts))
    for name, files, concepts in re.findall(r"^\| ([^|]+) \| (\d+) \| (\d+) \|", README, re.M)
}


@pytest.fixture(autouse=True)
def importable(monkeypatch):
    monkeypatch.syspath_prepend(SOURCE)


def files_of(folder):
    return {path.name for path in (PACKAGE / folder).glob("*.py")} - {"__init__.py"}


def named_by(row):
    """Return the modules that a row names: what somebody has to know of to write it."""
    return set(re.findall(r"crank_rig\.[\w.]+(?=:)", repr(row)))


def test_a_mechanism():
    from crank_rig.crank.parts import PARTS

    assert isinstance(PARTS, MechanismParts)
    # Settings, view, laws, reference, plant, hazards, measures, figure, comparison, procedure,
    # scene.
    offered = {
        PARTS.settings, PARTS.view, PARTS.scene, *PARTS.measures, *PARTS.figures,
        *PARTS.comparisons, *PARTS.procedures, *PARTS.references.values(),
        *(model.plant for model in PARTS.plants.values()),
        *(model.hazards for model in PARTS.plants.values()),
    }  # fmt: skip
    concepts = len(offered) + bool(PARTS.controllers)
    assert ROWS["mechanism, with all that belongs to it"] == (len(files_of("crank")), concepts)


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("law for a mechanism that there is", "FOR_CYLINDER"),
        ("reference for a mechanism that there is", "FOR_ARM"),
    ],
)
def test_an_addition(name, row):
    from crank_rig.extras import parts

    added = getattr(parts, row)
    assert isinstance(added, Additions)
    modules = named_by(added)
    files = len(modules) + 1  # and the row's own
    assert ROWS[name] == (files, len(modules) + 1)


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("driver that is simulated by its description", "load_cell"),
        ("driver with a code and a simulation of its own", "tecno"),
    ],
)
def test_a_driver(name, folder):
    import importlib

    row = importlib.import_module(f"crank_rig.{folder}.parts").PARTS
    assert isinstance(row, DriverParts)
    codec = "codec.py" in files_of(folder)
    concepts = 1 + len(named_by(row)) + codec  # the row, what it names, and the code
    assert ROWS[name] == (len(files_of(folder)), concepts)


def test_every_file_that_is_named_is_there():
    for folder, name in re.findall(r"`(crank|load_cell|tecno|extras)/(\w+\.py)?`", README):
        assert (PACKAGE / folder / name).exists()
    section = README[README.index("**Mechanism**") : README.index("What was loaded")]
    for name in re.findall(r"`(\w+\.py)`", section):
        assert (PACKAGE / "crank" / name).exists(), name


@pytest.mark.parametrize("name", ["cylinder", "joint", "arm", "legs", "pneumatic", "servo"])
def test_the_readme_of_mechanisms_names_every_file_where_it_is(name):
    """Its first table is of what each folder has, the second of what some have besides."""
    folder = ROOT / "rig" / "mechanisms"
    every, some = (folder / "README.md").read_text().split("| file | where |")
    row = re.compile(r"^\| (`[^|]+) \| ([^|]+) \| ", re.M)
    common = {file for files, _ in row.findall(every) for file in re.findall(r"[\w/.]+", files)}
    own = {
        file
        for files, where in row.findall(some)
        if re.search(rf"\b{name}\b", where)
        for file in re.findall(r"[\w/.]+", files)
    }
    there = {
        path.name if path.is_file() else f"{path.name}/"
        for path in (folder / name).iterdir()
        if not path.name.startswith("_")
    }
    outgrown = {f"{file.removesuffix('/')}.py" for file in there if file.endswith("/")}
    assert own <= there <= own | common | {file.replace(".py", "/") for file in common}
    if name not in ("pneumatic", "servo"):
        assert common <= there | outgrown
