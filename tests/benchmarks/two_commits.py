"""Two commits beside each other: what each command costs now over what it cost then.

    python tests/benchmarks/two_commits.py 4aab21b HEAD [--rounds 8] [--only check]

Each commit is checked out into a folder of its own, with caches of its own. A round runs every
command once on either, in turn, and the next round begins with the other; so whatever else the
machine does falls on both. What is compared is processor time of the process and its children: the
median of the rounds' ratios, and the interval that holds it in 95 of 100 resamplings of the rounds.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from scipy.stats import bootstrap

COMMANDS = (
    "--help",
    "list",
    "list runs --out OUT",
    "check cylinder",
    "check joint",
    "check cylinder-step",
    "explain tracking_rms",
    "status cylinder",
    "run cylinder-step --on sim --no-report --out OUT",
    "run cylinder-step --on sim --out OUT",
    "run cylinder-sine --on virtual --no-report --out OUT",
    "run joint-ideal-circle --on sim --no-report --out OUT",
    "run arm-wrist-hit --on virtual --no-report --out OUT",
    "run legs-walk --on virtual --no-report --out OUT",
)
RESAMPLINGS = 2000


def main() -> int:
    """Measure, and print a table in Markdown; 1 if a command surely got slower by a tenth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--only", default="", help="commands that contain this text")
    asked = parser.parse_args()
    commands = [command for command in COMMANDS if asked.only in command]
    with ExitStack() as stack:
        folders = [stack.enter_context(checked_out(at)) for at in (asked.before, asked.after)]
        costs = measure(folders, commands, asked.rounds)
    write = sys.stdout.write
    write(f"| `rig …` | {asked.before}, s | {asked.after}, s | ratio | 95 % |\n")
    write("|---|---|---|---|---|\n")
    slower = False
    for command, (before, after) in costs.items():
        row = f"| `{command.replace(' --out OUT', '')}` | {told(before)} | {told(after)} |"
        if before is None or after is None:
            write(f"{row} | |\n")
            continue
        ratios = after / before
        low, high = interval_of(ratios)
        slower |= low > 1.1
        write(f"{row} {np.median(ratios):.2f} | {low:.2f} to {high:.2f} |\n")
    return int(slower)


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Yield a folder with this commit's files, and take it away again."""
    with tempfile.TemporaryDirectory(prefix="two-commits-") as parent:
        folder = Path(parent) / "tree"
        subprocess.run(["git", "worktree", "add", "-q", "--detach", folder, commit], check=True)
        try:
            yield folder
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", folder], check=True)


def measure(
    folders: list[Path], commands: list[str], rounds: int
) -> Mapping[str, tuple[np.ndarray | None, ...]]:
    """Return the processor time of each command's rounds on either commit, s; None: it fails."""
    costs = {}
    for command in commands:
        # The first call of each compiles, and tells what this commit does not have yet.
        runs = [cost_of(folder, command) is not None for folder in folders]
        kept: tuple[list[float], list[float]] = ([], [])
        for number in range(rounds):
            for which in (0, 1) if number % 2 else (1, 0):
                if runs[which]:
                    kept[which].append(cost_of(folders[which], command) or np.nan)
        costs[command] = tuple(
            np.array(values) if ran else None for values, ran in zip(kept, runs, strict=True)
        )
        sys.stderr.write(f"{command} …\n")
    return costs


def cost_of(folder: Path, command: str) -> float | None:
    """Return the processor time of a command of this tree, s; None if it fails."""
    environment = os.environ | {
        "PYTHONPATH": str(folder),
        "MPLBACKEND": "Agg",
        "XDG_CACHE_HOME": str(folder.parent / "cache"),
        "NUMBA_CACHE_DIR": str(folder.parent / "cache" / "numba"),
    }
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # a user's Python keeps what it compiled
    with tempfile.TemporaryDirectory() as out:
        arguments = command.replace("OUT", out).split()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ended = subprocess.run(
            [sys.executable, "-m", "rig", *arguments],
            cwd=folder,
            env=environment,
            capture_output=True,
            check=False,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if ended.returncode:
        return None
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def interval_of(ratios: np.ndarray) -> tuple[float, float]:
    """Return the interval of the median that 95 of 100 resamplings fall into."""
    found = bootstrap(
        (ratios,), np.median, n_resamples=RESAMPLINGS, method="percentile"
    ).confidence_interval
    return float(found.low), float(found.high)


def told(costs: np.ndarray | None) -> str:
    return "fails" if costs is None else f"{np.median(costs):.2f}"


if __name__ == "__main__":
    sys.exit(main())
