"""What the environment says, and what it must not: drawn values of every variable that is read."""

import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from drivers.can.interface_names import _list_of_allowed
from rig import kernel_cache
from rig.experiment.fault_latch import FaultLatch

READ = (
    "HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "COLUMNS", "LINES", "TERM",
    "MPLBACKEND", "MPLCONFIGDIR", "OPENBLAS_NUM_THREADS", "LANG", "LC_ALL", "TZ", "NO_COLOR",
    "NUMBA_NUM_THREADS", "TMPDIR", "PWD",
)  # fmt: skip
SAID = (
    "", "x", "-1", "0", "9" * 20, "/dev/null", "/dev/null/x", "../..", "a\nb", "/nowhere",
    "x" * 5000, "\x1b]0;pwned\x07", "C", "module://os", "nan", "%s", "$(touch PWNED)",
)  # fmt: skip
DRAWS = """
from rig.cli import invoke
code = invoke(["list", "rigs"]) or invoke(["check", "cylinder"])
from matplotlib.figure import Figure
Figure().savefig("drawn.png")
raise SystemExit(code)
"""


def try_in(folder, seed):
    chance = random.Random(seed)
    names = chance.sample(READ, chance.choice([1, 2, 5]))
    said = {name: chance.choice(SAID) for name in names}
    done = subprocess.run(
        [sys.executable, "-c", DRAWS], cwd=folder, env={**os.environ, **said}, timeout=120,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, (said, done.stderr)
    assert "Traceback" not in done.stderr and "\x1b]" not in done.stdout + done.stderr
    assert not (folder / "PWNED").exists()


@pytest.mark.parametrize("seed", range(2))
def test_no_variable_is_a_traceback(tmp_path, seed):
    try_in(tmp_path, seed)


@pytest.mark.slow
@pytest.mark.lengthy
@pytest.mark.parametrize("seed", range(2, 40))
def test_many_variables_are_no_tracebacks(tmp_path, seed):
    try_in(tmp_path, seed)


@pytest.mark.parametrize("backend", ["nonsense", "module://nowhere.at.all", "TkAgg", "\x1b"])
def test_figures_are_files_whatever_is_set_for_a_notebook(tmp_path, backend):
    subprocess.run(
        [sys.executable, "-c", DRAWS], cwd=tmp_path, env={**os.environ, "MPLBACKEND": backend},
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    assert (tmp_path / "drawn.png").exists()


@pytest.mark.parametrize("said", ["", "x", "../x", "."])
def test_no_folder_of_the_user_is_another_one_elsewhere(tmp_path, monkeypatch, said):
    """A latched fault stays latched, and whose folder one is in allows no interface."""
    for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "HOME"):
        monkeypatch.setenv(name, said)
    found = []
    for place in (tmp_path, Path("/")):
        monkeypatch.chdir(place)
        found.append((FaultLatch("cylinder").path.absolute(), _list_of_allowed().absolute()))
    assert found[0] == found[1]


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "HOME"])
def test_no_kernel_comes_from_the_working_folder(tmp_path, monkeypatch, variable):
    """What is kept of compiled kernels runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernel_cache, "_beside", lambda: Path("/dev/null/x"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", "of who runs the tests")  # so that it is put back
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(variable, "here")
    (temporary := tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(temporary))
    kernel_cache.keep_kernels()
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == temporary


SCRIPT = """
import rig
try:
    rig.run("cylinder-step", on="sim", report=False, out="runs")
except rig.ConfigurationError as error:
    print(error)
"""


@pytest.mark.parametrize("words", ["-c", "-m"])
def test_a_program_that_has_numba_compile_nothing(tmp_path, words, monkeypatch):
    """The command line does not heed it; in a program of the user's it may be what is wanted."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    command = ["rig", "run", "cylinder-step", "--on", "sim", "--no-report", "--out", "runs"]
    done = subprocess.run(
        [sys.executable, words, *([SCRIPT] if words == "-c" else command)],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ("NUMBA_DISABLE_JIT is set" in done.stdout) == (words == "-c")
    assert len(list(tmp_path.glob("runs/*/metrics.json"))) == (words == "-m")
