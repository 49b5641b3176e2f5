"""Installed and not cloned: read-only packages and home, no network, no kernel compiled before."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ALONE = 'mount --bind "$1" "$1" && mount -o remount,bind,ro "$1" && shift && exec "$@"'

pytestmark = pytest.mark.slow


def install(folder):
    """Install the program into an environment that sees the packages of this one."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    (own,) = folder.glob("lib/python*/site-packages")
    around = {path: None for path in sys.path if path.endswith("site-packages")}
    around |= dict.fromkeys((sysconfig.get_path("purelib"), sysconfig.get_path("platlib")))
    (own / "around.pth").write_text("\n".join(around))  # what builds it is there, too
    options = ["--quiet", "--no-index", "--no-deps", "--no-build-isolation"]
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", python, "install", *options, ROOT],
        check=True, env={**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1"},
    )  # fmt: skip
    return own


class Stranger:
    """Somebody whose installation and home nobody can write, with no network."""

    def __init__(self, folder):
        self.installed, self.elsewhere = folder / "fixed", folder / "elsewhere"
        self.installed.mkdir()
        self.elsewhere.mkdir()
        (folder / "scratch").mkdir()
        self.packages = install(self.installed / "venv")
        (self.installed / "home").mkdir()
        kept = ("PYTHONPATH", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "XDG_STATE_HOME", "MPLCONFIGDIR")
        self.environment = {k: v for k, v in os.environ.items() if k not in kept}
        self.environment |= {
            "HOME": str(self.installed / "home"), "TMPDIR": str(folder / "scratch"),
            "MPLBACKEND": "Agg",
        }  # fmt: skip

    def alone(self, *words):
        """Run a program; return its output and the seconds of processor that it took."""
        before = os.times()
        done = subprocess.run(
            ["unshare", "-rmn", "sh", "-c", ALONE, "sh", self.installed, *words],
            cwd=self.elsewhere, env=self.environment, capture_output=True, text=True, check=False,
        )  # fmt: skip
        after = os.times()
        took = sum(after[2:4]) - sum(before[2:4])
        assert "Traceback" not in done.stderr, done.stderr
        return done, took

    def rig(self, *words):
        done, took = self.alone(self.installed / "venv" / "bin" / "rig", *words)
        assert done.returncode == 0, done.stderr
        return done, took


@pytest.fixture(scope="module")
def stranger(tmp_path_factory):
    pytest.importorskip("hatchling")  # which builds the program
    made = Stranger(tmp_path_factory.mktemp("installed"))
    if made.alone("true")[0].returncode != 0:
        pytest.skip("this machine lets nobody make a folder read-only")
    return made


def test_everything_runs_from_what_was_installed(stranger):
    program = "import rig, sys; sys.stdout.write(rig.__file__)"
    where, _ = stranger.alone(stranger.installed / "venv" / "bin" / "python", "-c", program)
    assert Path(where.stdout) == stranger.packages / "rig" / "__init__.py"
    kept, _ = stranger.alone("touch", stranger.packages / "rig" / "new")
    assert kept.returncode != 0 and "Read-only" in kept.stderr
    listed, _ = stranger.rig("list", "experiments", "--json")
    shipped = list((ROOT / "configs" / "experiments").glob("*.yaml"))
    assert all(f'"{path.stem}"' in listed.stdout for path in shipped)
    for profile in sorted(path.stem for path in (ROOT / "configs" / "rigs").glob("*.yaml")):
        if profile != "cylinder-uncalibrated":
            stranger.rig("check", profile)
    stranger.rig("schema", "profile")
    stranger.rig("--version")


def test_everything_that_is_shipped_is_in_the_installation(stranger):
    for package in ("rig", "drivers", "controllers", "configs"):
        for path in (ROOT / package).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                assert (stranger.packages / path.relative_to(ROOT)).is_file(), path


def test_the_first_run_takes_at_most_twice_the_second(stranger):
    """Of the first experiment of the README. What is compiled then: the plant and its exchange."""
    took = []
    for number in range(2):
        done, seconds = stranger.rig("run", "cylinder-sine", "--out", f"runs{number}")
        took.append(seconds)
        (run,) = (stranger.elsewhere / f"runs{number}").iterdir()
        assert (run / "report.html").exists(), done.stderr
    sys.stdout.write(f"{took[0]:.1f} s and then {took[1]:.1f} s of processor\n")
    assert took[0] < 2.0 * took[1], took
    assert list((stranger.installed.parent / "scratch").rglob("*.nbi"))
    for command in (["report", str(run)], ["export", str(run), "--format", "csv"],
                    ["replay", str(run)]):  # fmt: skip
        stranger.rig(*command)
    assert (run / "log.csv").exists()
