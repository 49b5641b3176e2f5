"""What pages show of other programs than `rig`: scripts, tests and packages that there are.

Nothing of it is run: scripts are asked whether they take these words, pytest which tests it finds.
"""

import argparse
import re
import runpy
import subprocess
import sys
import tomllib
from importlib.metadata import metadata

import pytest
from shown_commands import PAGES, ROOT, commands_of

COMMANDS = sorted({(c.words, c.page) for page in PAGES for c in commands_of(page)})
FILLED = {"BEFORE", "AFTER", "NAME", "…", "FILE::TEST[CASE]", "path/to/your/tests"}
"""Words that a reader fills in."""
PASSES_ON = {"tests/vcan": "tests/vcan/test_socketcan.py", "tests/versions": "tests/test_words.py"}
"""Scripts that hand all options to pytest, with a file of the tests that they run."""
NONE_SELECTED = 5
"""Pytest's exit code where words are right and choose no test."""
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def shown(program, *first):
    """Return what is shown of a program, each once, without the program."""
    found = dict.fromkeys(words[1:] for words, _ in COMMANDS if words[0] == program)
    return [words for words in found if words[: len(first)] == first]


class Taken(BaseException):
    """A script has understood its words, and would begin."""


def files_of(words):
    """Return those words that have to be files of the project: all with a folder."""
    paths = [word.partition("=")[2] or word for word in words if not FILLED & {word, word[-1:]}]
    return [path.partition("::")[0] for path in paths if re.match(r"[\w.-]+/", path)]


def test_every_file_that_is_named_is_there():
    others = {words for words, _ in COMMANDS if words[0] != "rig"}
    named = {path for words in others for path in files_of(words)}
    assert {path for path in named if not (ROOT / path).exists()} == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_test_that_is_named_is_there(page):
    there = {path.name for path in (ROOT / "tests").rglob("test_*.py")}
    assert {*re.findall(r"\btest_\w+\.py\b", page.read_text())} <= there


@pytest.mark.parametrize("words", shown("python"), ids=" ".join)
def test_a_script_takes_the_words_that_are_shown(words, monkeypatch):
    script, *given = words
    if script == "-c":
        compile(given[0], "shown", "exec")
        return
    if script in PASSES_ON:
        collected(given, PASSES_ON[script])
        return
    path = ROOT / script
    main = path / "__main__.py" if path.is_dir() else path
    if "argparse" not in main.read_text():
        assert not any(word.startswith("-") for word in given)
        return
    parse = argparse.ArgumentParser.parse_args

    def parse_only(self, args=None, namespace=None):
        raise Taken(parse(self, args, namespace))

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse_only)
    monkeypatch.setattr(sys, "argv", [str(main), *given])
    monkeypatch.setattr(sys, "path", [str(main.parent), *sys.path])
    with pytest.raises(Taken):
        runpy.run_path(str(main), run_name="__main__")


def collected(words, file):
    """Return whether pytest finds tests by these words, of a file if they name none."""
    named = [word for word in words if not FILLED & {word, word[-1:]}]
    marked = [] if "-m" in words else ["-m", "vcan" if "vcan" in file else "not vcan"]
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *named, "-n", "0", *marked,
         "--collect-only", "-q", *([] if files_of(named) else [file])],
        cwd=ROOT, check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert ran.returncode in (0, NONE_SELECTED), ran.stdout + ran.stderr
    return ran.returncode == 0


@pytest.mark.parametrize("words", shown("pytest"), ids=" ".join)
def test_pytest_finds_the_tests_that_are_shown(words):
    is_found = collected(words, "tests/test_words.py")
    assert is_found or not files_of(words)


@pytest.mark.parametrize("words", shown("pip", "install"), ids=" ".join)
def test_what_pip_is_to_install_has_these_extras(words):
    for word in words:
        package, _, extras = word.rstrip("]").partition("[")
        if not extras:
            continue
        if package in (".", PROJECT["name"]):
            known = PROJECT["optional-dependencies"]
        else:
            known = metadata(package).get_all("Provides-Extra")
        assert {*extras.split(",")} <= {*known}
