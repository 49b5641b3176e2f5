"""What is installed with this program: the versions that CI passed with, and their licences."""

import re
import tomllib
from email.message import Message
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
CONSTRAINTS = dict(
    line.split("==") for line in (ROOT / ".ci" / "constraints.txt").read_text().split()
)
CI_EXTRAS = ("multicast", "dask", "parquet", "watch", "test")
GPL = r"GPL|General Public"
LESSER = {"python-can"}  # LGPL: used as it is, and not changed


def needed(texts, extras=("",)):
    """Yield what requirements come to on this machine."""
    for text in texts:
        requirement = Requirement(text)
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras):
            yield requirement


def closure(texts):
    """Return the installed distributions that requirements draw in, by name."""
    found, waiting = {}, list(needed(texts))
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if name in found or name == "rig-controller":
            continue
        try:
            found[name] = metadata.distribution(requirement.name)
        except metadata.PackageNotFoundError:
            continue  # an extra that is not installed here
        waiting += needed(found[name].requires or (), ("", *requirement.extras))
    return found


def installed():
    """Return all that CI installs, by name: for users, and for the tests."""
    extras = PROJECT["optional-dependencies"]
    return closure([*PROJECT["dependencies"], *(r for name in CI_EXTRAS for r in extras[name])])


def licence(package):
    told = package.metadata.get("License-Expression") or package.metadata.get("License") or ""
    if not told and "License-File" in package.metadata:  # its title stands in the first line
        file = f"licenses/{package.metadata['License-File']}"
        told = (package.read_text(file) or "").strip()
    classes = package.metadata.get_all("Classifier") or []
    return " ".join([told.split("\n")[0], *(c for c in classes if c.startswith("License"))])


def test_nothing_that_is_installed_is_gpl():
    found = installed()
    assert len(found) > 60
    words = {name: licence(package) for name, package in found.items()}
    assert [name for name, text in words.items() if not text.strip()] == []
    gpl = {name for name, text in words.items() if re.search(GPL, text)}
    assert gpl <= LESSER
    assert all(re.search("LGPL|Lesser", words[name]) for name in gpl)


def test_the_versions_of_ci_are_exact_and_permitted():
    assert all(re.fullmatch(r"[0-9][\w.]*", version) for version in CONSTRAINTS.values())
    extras = [r for texts in PROJECT["optional-dependencies"].values() for r in texts]
    for requirement in needed([*PROJECT["dependencies"], *extras]):
        told = CONSTRAINTS.get(canonicalize_name(requirement.name))
        if told is not None:
            assert requirement.specifier.contains(Version(told), prereleases=True), requirement
    missing = {canonicalize_name(Requirement(r).name) for r in PROJECT["dependencies"]}
    assert missing <= CONSTRAINTS.keys()


def test_everything_that_is_installed_has_a_version_of_ci():
    assert installed().keys() <= CONSTRAINTS.keys()


def test_an_installed_gpl_would_be_seen(monkeypatch):
    """The same check on a distribution that is under it, as its classifier alone says."""
    package = metadata.distribution("numpy")
    told = Message()
    told["Classifier"] = "License :: OSI Approved :: GNU General Public License v3 (GPLv3)"
    monkeypatch.setattr(type(package), "metadata", told)
    assert re.search(GPL, licence(package))


def test_ci_uses_them():
    assert "PIP_CONSTRAINT" in (ROOT / ".ci" / "run").read_text()


@pytest.mark.parametrize("line", (ROOT / ".ci" / "constraints.txt").read_text().splitlines())
def test_a_line_is_a_name_and_a_version(line):
    assert re.fullmatch(r"[a-z0-9-]+==[\w.]+", line)
