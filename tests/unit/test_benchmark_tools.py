"""Programs that measure: what cannot be measured is refused in a line; what broke is no success."""

import os
import random
import resource
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


def compared(folder, *more, environment=None, stdout=subprocess.PIPE):
    return subprocess.run(
        words_of(*more), cwd=folder, stdout=stdout, stderr=subprocess.PIPE, text=True, check=False,
        env=environment,
    )  # fmt: skip


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
    for before, after, code, said in (
        ("well", "broken", 1, "broken, and did not at well"),
        ("broken", "well", 2, "broken, and not at well: whether"),
        ("broken", "broken", 2, "broken and at broken: whether"),
    ):
        ended = compared(repository, before, after, "--rounds", "4", "--only", "list runs")
        assert ended.returncode == code, ended.stdout + ended.stderr
        assert f"\n`rig list runs --out OUT` fails at {said}" in ended.stdout
        assert "rig list runs --out OUT fails: exit code 1\n" in ended.stderr
        assert left(repository) == []


def test_what_got_slower_is_told_from_what_did_not():
    drawn = np.random.default_rng(5)
    then = drawn.uniform(1.0, 1.1, 12)
    assert two_commits.tell("a", "b", {"list": (then, then * drawn.uniform(1.2, 1.3, 12))}) == 1
    assert two_commits.tell("a", "b", {"list": (then, then * drawn.uniform(0.9, 1.1, 12))}) == 0
    assert two_commits.tell("a", "b", {"list": (None, then), "check": (then, then)}) == 2
    assert two_commits.tell("a", "b", {"list": (None, None), "check": (then, then)}) == 2
    assert two_commits.tell("a", "b", {"list": (None, None), "check": (then, 2.0 * then)}) == 1
    assert two_commits.tell("a", "b", {"list": (then, None)}) == 1


REFUSED = [
    (["well", "no-such"], "there is no commit no-such"),
    (["well", "well", "--rounds", "3"], "4 rounds at least"),
    (["well", "well", "--rounds=-1"], "4 rounds at least"),
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
    ended = compared(repository, "well", "well", "--rounds", "4", "--only", "list runs")
    assert "left out: what is not committed here, of 1 tracked files" in ended.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_who_ends_it_leaves_nothing_checked_out(number, repository):
    commit(repository, "slow", sleeps=True)
    words = words_of("slow", "slow", "--only", "list runs")
    assert interrupted(words, repository, number, (repository / "sleeps").exists) == INTERRUPTED
    assert left(repository) == []


INTERRUPTED = (130, "Interrupted.\n")


def interrupted(words, folder, number, is_there, environment=None):
    """Start a program, send it a signal once it is there; return how it ended, and what it said."""
    process = subprocess.Popen(
        words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        env=environment,
    )  # fmt: skip
    until = time.monotonic() + 20.0
    while not is_there() and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(number)
    _, said = process.communicate(timeout=30.0)
    return process.returncode, said


HOOK = """#!/bin/sh
touch {sleeps}
while true; do echo x > more-$(date +%N); done
"""
"""Goes on writing into what is checked out."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_who_ends_it_while_it_checks_out_leaves_nothing(number, repository):
    commit(repository, "well")
    hook, sleeps = repository / ".git" / "hooks" / "post-checkout", repository / "sleeps"
    hook.write_text(HOOK.format(sleeps=sleeps))
    hook.chmod(0o755)
    assert interrupted(words_of("well", "well"), repository, number, sleeps.exists) == INTERRUPTED
    time.sleep(0.2)
    assert left(repository) == []


@pytest.mark.parametrize("program", ["two_commits.py", "scale.py"])
def test_ctrl_c_is_told_while_it_imports(program, tmp_path):
    slow = f"import pathlib, time; pathlib.Path({str(tmp_path / 'here')!r}).touch(); time.sleep(99)"
    (tmp_path / "numpy.py").write_text(slow)
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    words, is_there = [sys.executable, str(BENCHMARKS / program)], (tmp_path / "here").exists
    assert interrupted(words, tmp_path, signal.SIGINT, is_there, environment) == INTERRUPTED


def test_a_table_that_cannot_be_written_is_no_success(repository):
    commit(repository, "well")
    words = "well", "well", "--rounds", "4", "--only", "list runs"
    with Path("/dev/full").open("w") as full:
        ended = compared(repository, *words, stdout=full)
    assert ended.returncode == 2
    assert ended.stderr.endswith(": No space left on device\n")
    assert "Traceback" not in ended.stderr


def test_who_does_not_read_the_table_is_told_nothing_of_it(repository):
    commit(repository, "well")
    ours, theirs = os.pipe()
    os.close(ours)
    words = "well", "well", "--rounds", "4", "--only", "list"
    ended = compared(repository, *words, stdout=theirs)
    os.close(theirs)
    assert ended.returncode in (0, 1, 2)  # 2: Python writes each line at once, if asked to
    assert ended.stderr == "list …\nlist runs --out OUT …\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_who_ends_a_measurement_of_scale_leaves_nothing(number, tmp_path):
    words = [sys.executable, str(BENCHMARKS / "scale.py"), "--only", "npz", "--minutes", "1"]
    words += ["--folder", str(tmp_path)]

    def is_recording():
        return any(tmp_path.glob("*/runs/*/log.mcap"))

    assert interrupted(words, tmp_path, number, is_recording) == INTERRUPTED
    assert list(tmp_path.iterdir()) == []


def test_a_disk_without_room_is_a_sentence(tmp_path):
    words = [sys.executable, str(BENCHMARKS / "scale.py"), "--only", "npz", "--minutes", "1"]
    ended = subprocess.run(
        [*words, "--folder", str(tmp_path)], capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000)),
    )  # fmt: skip
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert ended.stderr.startswith("cannot write the log ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("figure", ["missing/x.png", "x.txt", "/"])
def test_a_figure_that_cannot_be_drawn_is_refused_at_the_start(figure, tmp_path):
    words = [sys.executable, str(BENCHMARKS / "scale.py"), "--figure", figure]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert f"argument --figure: {figure} " in ended.stderr


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
