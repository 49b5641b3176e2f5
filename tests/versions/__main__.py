"""The suite on other versions: ``python tests/versions [--all] [PYTEST OPTION …]``.

An environment is made for each interpreter that this machine has, with the newest dependencies, and
one of the lowest interpreter with the lowest that `pyproject.toml` states. The fast part of the
suite runs in each, and experiments whose ``metrics.json`` must be the same (`comparison`):
one of each mechanism, or with ``--all`` every shipped one. What is absent is said, and no failure.
The exit code is 0, or 1 if anything failed.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from comparison import same_bytes, same_numbers
from interpreters import VERSIONS, find_interpreters

ROOT = Path(__file__).parents[2]
FAST = ("tests/wire", "tests/unit/config", "tests/unit/record", "tests/unit/report",
        "tests/unit/runtime", "tests/unit/drivers", "tests/unit/frames",
        "tests/contract/test_eds_under_canopen.py")  # fmt: skip
ARITHMETIC = ("numpy", "scipy", "numba", "llvmlite", "mujoco")
ONE_EACH = ("cylinder-step", "joint-range", "arm-elbow-turnback", "legs-squat")


class Environment(NamedTuple):
    """A Python with the dependencies in some resolution."""

    name: str
    interpreter: Path
    resolution: str


def main() -> int:
    """Try every environment; return the exit code."""
    options = [word for word in sys.argv[1:] if word != "--all"]
    shipped = sorted(path.stem for path in (ROOT / "configs" / "experiments").glob("*.yaml"))
    experiments = shipped if "--all" in sys.argv[1:] else ONE_EACH
    uv = shutil.which("uv", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if uv is None:
        say("SKIPPED: all of them: uv is not installed")
        return 0
    failed = []
    found: dict[Environment, dict[str, str]] = {}
    arithmetic: dict[Environment, str] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for environment in environments():
            folder = Path(scratch, environment.name)
            python = install(uv, environment, folder)
            if python is None or not passes(python, folder, options):
                failed.append(environment.name)
            if python is not None:
                found[environment] = metrics(python, folder, experiments)
                arithmetic[environment] = versions_of_arithmetic(python)
                shutil.rmtree(folder)  # a gigabyte
    failed += compare(found, arithmetic)
    say(f"FAILED: {', '.join(failed)}" if failed else "all passed")
    return 1 if failed else 0


def compare(
    found: dict[Environment, dict[str, str]], arithmetic: dict[Environment, str]
) -> list[str]:
    """Compare the metrics of every environment with the last one's; return what is wrong."""
    failed: list[str] = []
    *others, last = found or [None]
    for other in others:
        differing = list(same_bytes(found[other], found[last]))
        how = "the same bytes" if not differing else f"not the same bytes: {', '.join(differing)}"
        say(f"metrics.json of {len(found[last])} experiments, {other.name}, {last.name}: {how}")
        if differing and arithmetic[other] != arithmetic[last]:
            say(f"they add up with {arithmetic[other]} and {arithmetic[last]}")
            differing = list(same_numbers(found[other], found[last]))
        for text in differing:
            say(text)
        failed += [f"metrics of {other.name}"] * bool(differing)
    return failed


def environments() -> list[Environment]:
    """Return what is tried; say what this machine has no interpreter for."""
    found = find_interpreters()
    for version in VERSIONS:
        if version not in found:
            say(f"SKIPPED: Python {version}: no interpreter of it is on this machine")
    made = [Environment(f"{v}-newest", path, "highest") for v, path in found.items()]
    lowest = VERSIONS[0]
    if lowest in found:
        made.insert(0, Environment(f"{lowest}-lowest", found[lowest], "lowest-direct"))
    return made


def install(uv: str, environment: Environment, folder: Path) -> Path | None:
    """Make an environment with the program and its tests' tools; None if that fails."""
    say(f"== {environment.name}: {environment.interpreter}")
    python = folder / "bin" / "python"
    plain = {k: v for k, v in os.environ.items() if k not in ("PIP_CONSTRAINT", "UV_CONSTRAINT")}
    for words in (
        ["venv", "--quiet", "--python", environment.interpreter, folder],
        ["pip", "install", "--quiet", "--python", python, "--resolution", environment.resolution,
         f"{ROOT}[test]"],
    ):  # fmt: skip
        if subprocess.run([uv, *words], env=plain, check=False).returncode != 0:
            return None
    return python


def passes(python: Path, folder: Path, options: list[str]) -> bool:
    """Whether the fast part of the suite passes."""
    words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow and not benchmark"]
    words += [*options, *([] if any(Path(o).exists() for o in options) else FAST)]
    return _run(python, folder, words).returncode == 0


def metrics(python: Path, folder: Path, experiments: tuple[str, ...] | list[str]) -> dict[str, str]:
    """Return ``metrics.json`` of each experiment that could be run."""
    done = _run(python, folder, [Path(__file__).with_name("same_metrics.py"), *experiments], True)
    if done.returncode != 0:
        say(done.stderr)
    return dict(json.loads(line) for line in done.stdout.splitlines() if line.startswith("["))


def versions_of_arithmetic(python: Path) -> str:
    """Return the versions of what computes: the newest numpy is not the same on every Python."""
    code = (
        "import sys; from importlib.metadata import version\n"
        "print(*(f'{name} {version(name)}' for name in sys.argv[1:]), sep=', ')"
    )
    told = subprocess.run(
        [python, "-c", code, *ARITHMETIC], text=True, capture_output=True, check=True
    )
    return told.stdout.strip()


def _run(
    python: Path, folder: Path, words: list[str | Path], is_kept: bool = False
) -> "subprocess.CompletedProcess[str]":
    environment = {
        **os.environ,
        "PATH": f"{python.parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "NUMBA_CACHE_DIR": str(folder / "kernels"),  # of another numba, and not to be mixed
        "PYTHONPYCACHEPREFIX": str(folder / "bytecode"),
        "MPLBACKEND": "Agg",
    }
    return subprocess.run(
        [python, *words], cwd=ROOT, env=environment, text=True, capture_output=is_kept, check=False
    )


def say(text: str) -> None:
    """Tell what is done."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
