"""Two commits beside each other: what each command costs now over what it cost then.

    python tests/benchmarks/two_commits.py 4aab21b HEAD [--rounds 8] [--only check]

Each commit is checked out into a folder of its own, with caches of its own. A round runs every
command once on either, in turn, and the next round begins with the other; so whatever else the
machine does falls on both. What is compared is processor time of the process and its children: the
median of the rounds' ratios, and the interval that holds it in 95 of 100 resamplings of the rounds.
It ends with 1 if a command surely got slower by a tenth, or fails at the later commit alone, and
with 2 if any command was not measured: it fails at the earlier commit, or at both.
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

import endings
from endings import UNMEASURED, Unmeasured, called, folder_for_a_while, last_line, talk, unheard

if __name__ == "__main__":
    endings.take_over()

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
SLOWER = 1.1
"""A command surely got slower whose ratio is above it with all of its interval."""


FEWEST = 4
"""Rounds: of two, two commits that differ in words had a ratio of 0.91 to 0.97."""


def main() -> int:
    """Measure, print a table in Markdown, and return what the program ends with."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--rounds", type=several, default=8, help=f"{FEWEST} or more")
    parser.add_argument("--only", default="", help="commands that contain this text")
    asked = parser.parse_args()
    commands = [command for command in COMMANDS if asked.only in command]
    if not commands:
        there = "".join(f"\n  {command}" for command in COMMANDS)
        parser.error(f"no command contains {asked.only!r}; there are:{there}")
    check_commits(asked.before, asked.after)
    with ExitStack() as stack:
        folders = [stack.enter_context(checked_out(at)) for at in (asked.before, asked.after)]
        costs = measure(folders, commands, asked.rounds)
    return tell(asked.before, asked.after, costs)


def several(text: str) -> int:
    """Return a number of rounds."""
    if not text.isdecimal() or int(text) < FEWEST:
        told = f"it is {text}, and an interval takes {FEWEST} rounds at least"
        raise argparse.ArgumentTypeError(told)
    return int(text)


def check_commits(*commits: str) -> None:
    """Refuse what is no commit of the clone that this is run in; say what is measured of neither.

    Raises
    ------
    Unmeasured
        There is no git, no clone, or no such commit.
    """
    try:
        if git("rev-parse", "--git-dir").returncode:
            raise Unmeasured(f"{Path.cwd()} is in no clone of the project: run this from one")
    except FileNotFoundError as error:
        raise Unmeasured("git is not installed: commits are checked out with it") from error
    for commit in commits:
        if git("rev-parse", "--verify", "--quiet", f"{commit}^{{commit}}").returncode:
            raise Unmeasured(f"there is no commit {commit} in this clone; git log shows them")
    changed = git("status", "--porcelain", "--untracked-files=no").stdout.splitlines()
    if changed:
        talk(f"left out: what is not committed here, of {len(changed)} tracked files")


def git(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """Call git and return what it says."""
    return called("git", *words)


def tell(before: str, after: str, costs: Mapping[str, tuple[np.ndarray | None, ...]]) -> int:
    """Print the table; return 1 if a command surely got slower or broke, 2 if one has no ratio."""
    write = sys.stdout.write
    write(f"| `rig …` | {before}, s | {after}, s | ratio | 95 % |\n|---|---|---|---|---|\n")
    notes, is_worse, is_unmeasured = [], False, False
    for command, (then, now) in costs.items():
        row = f"| `{command.replace(' --out OUT', '')}` | {told(then)} | {told(now)} |"
        if then is None or now is None:
            write(f"{row} | |\n")
            notes.append(f"\n`rig {command}` {what_fails(before, after, then, now)}.\n")
            is_worse |= then is not None
            is_unmeasured |= then is None
            continue
        ratios = now / then
        low, high = interval_of(ratios)
        is_worse |= low > SLOWER
        write(f"{row} {np.median(ratios):.2f} | {low:.2f} to {high:.2f} |\n")
    write("".join(notes))
    return 1 if is_worse else UNMEASURED if is_unmeasured else 0


def what_fails(before: str, after: str, then: np.ndarray | None, now: np.ndarray | None) -> str:
    """Say where a command fails, and what follows."""
    if then is not None:
        return f"fails at {after}, and did not at {before}"
    where = f"{before}, and not at {after}" if now is not None else f"{before} and at {after}"
    return f"fails at {where}: whether it got slower was not measured"


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Yield a folder with this commit's files, and take it away again."""
    with folder_for_a_while("two-commits-") as parent:
        folder = parent / "tree"
        try:
            added = git("worktree", "add", "-q", "--detach", folder, commit)
            if added.returncode:
                first = added.stderr.strip().partition("\n")[0]  # a full disk: one for each file
                raise Unmeasured(f"cannot check out {commit} into {parent.parent}: {first}")
            yield folder
        finally:
            with unheard():  # twice: one that was not checked out to its end is locked
                git("worktree", "remove", "--force", "--force", folder)


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
                cost = cost_of(folders[which], command) if runs[which] else None
                if cost is None:  # once is enough
                    runs[which] = False
                else:
                    kept[which].append(cost)
        costs[command] = tuple(
            np.array(values) if ran else None for values, ran in zip(kept, runs, strict=True)
        )
        talk(f"{command} …")
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
    with tempfile.TemporaryDirectory(dir=folder.parent) as out:
        arguments = command.replace("OUT", out).split()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ended = called(sys.executable, "-m", "rig", *arguments, cwd=folder, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if ended.returncode:
        talk(f"rig {command} fails: {last_line(ended)}")
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
    endings.end(main())
