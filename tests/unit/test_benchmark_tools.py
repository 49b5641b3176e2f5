"""Programs that measure: what cannot be measured is refused in a line; what broke is no success."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

import two_commits

BENCHMARKS = Path(two_commits.__file__).parent

PROGRAM = """
import sys
from pathlib import Path
times = Path(__file__).parents[2] / f"times-{sys.argv[1]}"
times.open("a").write("x")
bad = BAD
if sys.argv[1] in bad and times.stat().st_size >= bad[sys.argv[1]]:
    sys.exit(1)
if sys.argv[1] == "list" and SLEEPS:
    Path(REPOSITORY, "sleeps").touch()
    import time
    time.sleep(300.0)
sum(range(30_000 * WORK))
"""
"""A project whose commands fail from the call of this number on."""


@pytest.fixture
def repository(tmp_path, monkeypatch):
    folder = tmp_path / "clone"
    (folder / "rig").mkdir(parents=True)
    for name in ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    (folder / "rig" / "__init__.py").touch()
    git(folder, "init", "-q")
    return folder


def git(folder, *words):
    who = ["-c", "user.name=A", "-c", "user.email=a@b.c"]
    ended = subprocess.run(["git", *who, *words], cwd=folder, check=True, capture_output=True)
    return ended.stdout.decode()


def commit(folder, tag, *, bad=(), work=1, sleeps=False):
    """Commit a project; `bad`: the call of each command that fails first."""
    text = PROGRAM.replace("BAD", repr(dict(bad))).replace("WORK", str(work))
    text = text.replace("SLEEPS", str(sleeps)).replace("REPOSITORY", repr(str(folder)))
    (folder / "rig" / "__main__.py").write_text(text)
    git(folder, "add", ".")
    git(folder, "commit", "-qm", tag, "--allow-empty")
    git(folder, "tag", tag)


def words_of(*more):
    return [sys.executable, str(BENCHMARKS / "two_commits.py"), *more]


def compared(folder, *more, environment=None):
    return subprocess.run(
        words_of(*more), cwd=folder, capture_output=True, text=True, check=False, env=environment
    )


def left(folder):
    """Return what is checked out beside the clone, and which folders were made for it."""
    trees = git(folder, "worktree", "list").splitlines()[1:]
    return [*trees, *folder.parent.glob("two-commits-*")]


@pytest.mark.parametrize("seed", range(3))
def test_what_fails_at_the_later_commit_alone_is_a_regression(seed, repository):
    drawn = random.Random(seed)
    call = drawn.randint(1, 3)  # of three: the first one warms up
    commit(repository, "well")
    commit(repository, "broken", bad={"list": call})
    for before, after, code in (
        ("well", "broken", 1),
        ("broken", "well", 0),
        ("broken", "broken", 0),
    ):
        ended = compared(repository, before, after, "--rounds", "2", "--only", "list runs")
        assert ended.returncode == code, ended.stdout + ended.stderr
        assert ended.stdout.count("fails") == (2 if before == after or code else 1)
        assert (f"`rig list runs --out OUT` fails at {after}" in ended.stdout) == bool(code)
        assert left(repository) == []


def test_what_got_slower_is_told_from_what_did_not():
    drawn = np.random.default_rng(5)
    then = drawn.uniform(1.0, 1.1, 12)
    assert two_commits.tell("a", "b", {"list": (then, then * drawn.uniform(1.2, 1.3, 12))}) == 1
    assert two_commits.tell("a", "b", {"list": (then, then * drawn.uniform(0.9, 1.1, 12))}) == 0
    assert two_commits.tell("a", "b", {"list": (None, then), "check": (None, None)}) == 0
    assert two_commits.tell("a", "b", {"list": (then, None)}) == 1


REFUSED = [
    (["well", "no-such"], "there is no commit no-such"),
    (["well", "well", "--rounds", "1"], "2 rounds at least"),
    (["well", "well", "--rounds=-1"], "2 rounds at least"),
    (["well", "well", "--only", "zzz"], "  check cylinder"),
]


@pytest.mark.parametrize(("words", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_what_cannot_be_measured_is_refused_at_once(words, said, repository):
    commit(repository, "well")
    ended = compared(repository, *words)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert said in ended.stderr and "Traceback" not in ended.stderr
    assert left(repository) == []


def test_without_a_clone_or_git_a_line_says_so(repository, tmp_path):
    commit(repository, "well")
    ceiling = os.environ | {"GIT_CEILING_DIRECTORIES": str(tmp_path.parent)}
    ended = compared(tmp_path, "well", "well", environment=ceiling)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1) and "clone" in ended.stderr
    ended = compared(repository, "well", "well", environment=os.environ | {"PATH": "/nowhere"})
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert "git is not installed" in ended.stderr


def test_what_is_not_committed_is_said_to_be_left_out(repository):
    commit(repository, "well")
    (repository / "rig" / "__main__.py").write_text("")
    ended = compared(repository, "well", "well", "--rounds", "2", "--only", "list runs")
    assert "left out: what is not committed here, of 1 tracked files" in ended.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_who_ends_it_leaves_nothing_checked_out(number, repository):
    commit(repository, "slow", sleeps=True)
    process = subprocess.Popen(
        words_of("slow", "slow", "--only", "list runs"),
        cwd=repository, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    until = time.monotonic() + 20.0
    while not (repository / "sleeps").exists() and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(number)
    _, said = process.communicate()
    assert (process.returncode, said) == (130, "Interrupted.\n")
    assert left(repository) == []


@pytest.mark.parametrize("program", ["missed_ticks.py", "scale.py"])
@pytest.mark.parametrize("minutes", ["0", "-2", "nan", "x"])
def test_no_minutes_are_refused(program, minutes):
    words = [sys.executable, str(BENCHMARKS / program), f"--minutes={minutes}"]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "argument --minutes: " in ended.stderr and "Traceback" not in ended.stderr


@pytest.mark.parametrize("program", ["missed_ticks.py", "scale.py"])
def test_without_pytest_a_line_says_what_installs_it(program, tmp_path):
    (tmp_path / "pytest.py").write_text("raise ModuleNotFoundError('No module named pytest')")
    ended = subprocess.run(
        [sys.executable, str(BENCHMARKS / program), "--help"],
        capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr.count("\n")) == (1, 1)
    assert "pip install -e '.[test]'" in ended.stderr
