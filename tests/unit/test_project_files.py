"""What `.github` tells is true: the version has an entry, the commands and files are there."""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[2]
GITHUB = ROOT / ".github"
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


def test_this_version_is_the_newest_entry_and_says_something():
    text = (GITHUB / "CHANGELOG.md").read_text()
    entries = re.findall(r"^## (\S+) - (\d{4}-\d\d-\d\d|to come)\n(.*?)(?=^## |\Z)", text,
                         re.MULTILINE | re.DOTALL)  # fmt: skip
    assert entries[0][0] == VERSION
    assert all(re.search(r"^- \S", body, re.MULTILINE) for _, _, body in entries)
    assert all(date != "to come" for _, date, _ in entries[1:])
    numbers = [tuple(map(int, version.split("."))) for version, _, _ in entries]
    assert numbers == sorted(numbers, reverse=True)


def test_the_command_says_the_version():
    done = subprocess.run(
        [sys.executable, "-m", "rig", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == metadata.version("rig-controller")


def test_files_that_are_named_are_there():
    for page in sorted(GITHUB.glob("*.md")):
        text = page.read_text()
        for target in re.findall(r"\]\(([^)]+)\)", text):
            assert (GITHUB / target).exists(), (page.name, target)
        folders = r"`((?:rig|drivers|controllers|configs|tests|\.ci)/[\w./-]*)`"
        for name in re.findall(folders, text):
            assert (ROOT / name).exists(), (page.name, name)


def test_the_settings_of_a_machine_are_where_it_is_said():
    from drivers.can import interface_names

    assert "/.config/rig/interfaces" in (GITHUB / "SECURITY.md").read_text()
    assert interface_names._list_of_allowed().parts[-2:] == ("rig", "interfaces")
