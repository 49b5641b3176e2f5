"""What the pages beside the code show is done as it is shown, and comes out as they say."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from shown_commands import PAGES, ROOT, commands_of

from rig.sweeping.sweep_file import is_sweep_file

NOT_HERE = {"EXPERIMENT", "--watch", "hardware"}
"""Words of a command that needs a reader, a browser or a rig."""
OF_SESSIONS = {"tutorial.md", "your-own-rig.md", "CHANGELOG.md", "reference.md"}
"""Pages whose commands are compared in `test_documents.py`, or that name what there was."""
ASKS = "rig calibrate cylinder regulators"
"""Waits for a yes at the terminal."""
LONG = {"rig calibrate cylinder --all"}
"""What takes minutes, and is done in `tests/closed_loop`."""


def shell(words, folder):
    """Run a command as who reads a page would, and return its exit code and what it said."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    own = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    done = subprocess.run(
        words, cwd=folder, env=own, check=False, text=True, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600,
    )  # fmt: skip
    return done.returncode, done.stdout


def simulated_runs():
    """Return the commands that run an experiment in simulation, each once."""
    found = {}
    for page in PAGES:
        if page.name not in OF_SESSIONS:
            for command in commands_of(page):
                words = command.words
                if words[:2] == ("rig", "run") and len(words) > 2 and not apart(words):
                    found.setdefault(words)
    return list(found)


def apart(words):
    """Return whether a command needs more than this computer."""
    return NOT_HERE & {*words} or any("vcan" in w or "multicast" in w or "my-" in w for w in words)


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize("words", simulated_runs(), ids=shlex.join)
def test_a_run_that_is_shown_keeps_its_bounds(words, tmp_path):
    """With another law or rig it may miss one, as bounds are the experiment's own rig's."""
    code, said = shell([*words, "--no-report"], tmp_path)
    is_another = any(word == "--rig" or word.startswith("law=") for word in words)
    assert code in ((0, 1) if is_another else (0,)), said


def blocks(page, begins):
    """Return the indented and fenced blocks of a page that begin so."""
    text = re.sub(r"^```\w*\n(.*?)^```$", indented, page.read_text(), flags=re.M | re.S)
    found = re.findall(r"(?:^    .*\n)+", text, re.M)
    plain = [re.sub("^    ", "", block, flags=re.M) for block in found]
    return [block for block in plain if block.startswith(begins)]


def indented(found):
    return re.sub("^", "    ", found[1], flags=re.M)


@pytest.mark.slow
def test_calibrating_as_the_page_shows(tmp_path):
    (tmp_path / "configs").mkdir()
    history = tmp_path / "configs/calibration/cylinder/history/regulators"
    (shown,) = blocks(ROOT / "rig/calibration/README.md", "rig calibrate")
    for line in shown.splitlines():
        command = line.partition("#")[0].strip()
        if "--on hardware" in command or command in LONG:
            continue
        kept = [path.stem for path in history.glob("*.yaml")]
        if kept:
            command = re.sub(r"2026-11-21\w*", kept[-1], command)
        code, said = shell([*shlex.split(command), *["--yes"] * (command == ASKS)], tmp_path)
        assert code == 0, f"{command}: {said}"
    assert re.search(r"^regulators +holds in simulation", said, re.M), said


@pytest.mark.slow
def test_sweeping_as_the_page_shows(tmp_path):
    page = ROOT / "rig/sweeping/README.md"
    (shown,) = blocks(page, "rig sweep")
    files = blocks(page, "experiment:")
    commands = [shlex.split(shown)]
    for number, text in enumerate(files):
        path = tmp_path / f"{number}.yaml"
        path.write_text(text)
        assert is_sweep_file(str(path))
        commands.append(["rig", "sweep", path.name])
    assert len(commands) == 3
    for number, command in enumerate(commands):
        few = ["--budget", "2 points", "--out", f"out-{number}"]
        code, said = shell([*command, *few], tmp_path)
        assert code == 0, said
        rows = (tmp_path / f"out-{number}" / "sweep.csv").read_text().splitlines()
        assert len(rows) == 3, rows
    for name in ("sweep.csv", "sweep.png", "sweep.html"):
        assert (tmp_path / "out-0" / name).exists()


@pytest.mark.slow
@pytest.mark.parametrize("page", [".readme/safety.md", "rig/faults/README.md"])
def test_a_scenario_that_is_shown_is_seen_and_harms_nobody(page, tmp_path):
    (text,) = blocks(ROOT / page, "rig: cylinder")
    (tmp_path / "scenario.yaml").write_text(text)
    code, said = shell(["rig", "faults", "run", "scenario.yaml"], tmp_path)
    assert code == 0, said


@pytest.mark.slow
def test_the_page_of_python_is_a_program(tmp_path):
    """One block builds on another, as on a page that is read from its top."""
    page = (ROOT / "rig/scripting/README.md").read_text()
    text = "\n".join(re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S))
    code, said = shell([sys.executable, "-c", text], tmp_path)
    assert code == 0, said
