"""Files and folders that this user may not read or write: a sentence with the command for it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CONFIGS = Path(__file__).parents[2] / "configs"
POWERLESS = ("setpriv", "--inh-caps=-all", "--ambient-caps=-all", "--bounding-set=-all")
"""Take from root what lets it read and write everything."""
pytestmark = pytest.mark.skipif(
    os.geteuid() == 0 and shutil.which(POWERLESS[0]) is None, reason="root may do everything"
)


def rig(folder, *words):
    prefix = POWERLESS if os.geteuid() == 0 else ()
    done = subprocess.run(
        [*prefix, sys.executable, "-m", "rig", *words],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def closed(tmp_path):
    """Take permissions away until the test has ended."""
    before = {}

    def close(path, mode):
        before[path] = path.stat().st_mode
        path.chmod(mode)

    yield close
    for path, mode in before.items():
        path.chmod(mode)


@pytest.fixture
def own(tmp_path):
    """Return a folder with configurations of one's own."""
    shutil.copytree(CONFIGS / "rigs", tmp_path / "configs" / "rigs")
    shutil.copytree(CONFIGS / "experiments", tmp_path / "configs" / "experiments")
    return tmp_path


def test_a_configuration_that_may_not_be_read_is_named_with_what_opens_it(own, closed):
    closed(own / "configs" / "rigs" / "cylinder.yaml", 0)
    said = (
        "error: cannot read configs/rigs/cylinder.yaml: Permission denied; give it: sudo chmod "
        "a+rX configs/rigs/cylinder.yaml\n"
    )
    assert rig(own, "check", "cylinder") == (2, "", said)
    assert rig(own, "sweep", "cylinder-sine", "--seeds", "0:1") == (2, "", said)
    code, shown, _ = rig(own, "list", "rigs")  # which opens no file that it cannot
    assert code == 0 and "cylinder-ideal" in shown


def test_a_folder_of_configurations_that_may_not_be_read_is_named(own, closed):
    closed(own / "configs", 0)
    for words in (["list", "rigs"], ["run", "cylinder-sine"]):
        code, shown, told = rig(own, *words)
        assert (code, shown) == (2, "")
        assert told.startswith("error: cannot read configs/")
        assert told.endswith(f"Permission denied; give it: sudo chmod a+rX {own / 'configs'}\n")


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (["new", "rig", "mine"], "cannot write mine.yaml: Permission denied; take it"),
        (["new", "driver", "mine"], "cannot write mine: Permission denied; take it"),
        (["commission", "cylinder"], "run folders cannot be kept in runs: "),
        (["compare", "cylinder-step", "--on", "sim"], "run folders cannot be kept in runs: "),
        (["commission", "cylinder", "--out", "/tmp"], "the record of cylinder cannot be kept in "),
    ],
)
def test_what_cannot_be_written_is_said_before_anything_is_done(own, closed, words, what):
    written = own / "configs" if "record" in what else own
    closed(written, 0o555)
    code, shown, told = rig(own, *words)
    assert (code, shown) == (2, "")
    assert told.startswith(f"error: {what}") and told.count("\n") == 1
    assert f"sudo chown $USER {written}" in told


def test_a_run_that_may_not_be_read_is_one_line_of_the_list(tmp_path, closed):
    runs = tmp_path / "runs"
    for name in ("2026-11-27T040533Z-a-sim", "notes"):
        (runs / name).mkdir(parents=True)
        closed(runs / name, 0)
    code, shown, told = rig(tmp_path, "list", "runs")
    assert code == 0, told
    assert "2026-11-27T040533Z-a-sim  unreadable" in shown and "notes" not in shown
    code, _, told = rig(tmp_path, "explain", "latest")
    assert code == 2
    assert (
        f"Permission denied; give it: sudo chmod a+rX {runs / '2026-11-27T040533Z-a-sim'}" in told
    )


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (["report"], ("/metrics.json: ", "; or report a copy: cp -r ")),
        (["export", "--format", "csv"], ("/log.csv: ", "; --out FILE writes elsewhere")),
    ],
)
def test_a_run_that_may_only_be_read_says_how_it_is_written_elsewhere(
    tmp_path, closed, words, what
):
    run = ("run", "cylinder-step", "--on", "sim", "--no-report", "--set", "metrics={}")
    assert rig(tmp_path, *run)[0] == 0
    (path,) = (tmp_path / "runs").iterdir()
    closed(path, 0o555)
    for file in path.iterdir():
        closed(file, file.stat().st_mode & 0o555)
    code, shown, told = rig(tmp_path, *words, "latest")
    assert (code, shown) == (2, "")
    file, elsewhere = what
    denied = f"runs/{path.name}{file}Permission denied; take it: sudo chown $USER {path}"
    assert told.startswith(f"error: cannot write {denied}{elsewhere}"), told
    assert told.count("\n") == 1
