"""Work that copies of a process share out is what one does, whichever of them are killed."""

import json
import random
import signal

import pytest
import warm_start

SHARE = """
import json, os, signal, sys, time
from pathlib import Path
from rig.report.copies import share_out
told, folder = json.loads(sys.argv[1]), Path(sys.argv[2])
parent = os.getpid()
def work(task):
    assert os.getpid() != parent
    how = told["tasks"][task]
    with (folder / task).open("a") as times:
        times.write("x")
    if how == "always" or (how == "once" and (folder / task).stat().st_size == 1):
        os.kill(os.getpid(), told["signal"])
    if how == "leaves":
        sys.exit(7)
    time.sleep(0.001 * len(task))
    return task[::-1]
print(*share_out(work, list(told["tasks"]), told["workers"]), sep="\\n")
print(len(Path("/proc/self/task", str(os.getpid()), "children").read_text().split()))
"""
WAYS = ("well", "well", "well", "once", "always", "leaves")


def shared_out(tasks, workers, number, folder):
    told = json.dumps({"tasks": tasks, "workers": workers, "signal": number})
    ended = warm_start.run([told, folder], SHARE)
    assert ended.returncode == 0, ended.stderr
    *results, left = ended.stdout.splitlines()
    assert left == "0"
    return results


@pytest.mark.parametrize("seed", range(8))
def test_whatever_is_killed_each_task_has_its_result(seed, tmp_path):
    drawn = random.Random(seed)
    tasks = {f"{k:x}-{'y' * drawn.randrange(9)}": drawn.choice(WAYS) for k in range(12)}
    number = drawn.choice([signal.SIGKILL, signal.SIGSEGV])
    results = shared_out(tasks, drawn.randint(1, 4), number, tmp_path)
    for (task, how), result in zip(tasks.items(), results, strict=True):
        tries = (tmp_path / task).stat().st_size
        assert tries in ((1,) if how == "well" else (1, 2))  # once: alone from the beginning
        if how == "well" or (how == "once" and tries == 2):
            assert result == task[::-1]
        else:
            said = "exit code 7" if how == "leaves" else number.name
            assert said in result
            assert ("memory" in result) == (said == "SIGKILL")


@pytest.mark.parametrize("error", ["PermissionError(13, 'no')", "ConfigurationError('no such')"])
def test_an_error_is_the_works_own_with_its_cause(error):
    program = f"""
from rig.hal import ConfigurationError
from rig.report.copies import share_out
def work(task):
    raise RuntimeError(task) from {error}
try:
    share_out(work, ["a"], 2)
except RuntimeError as error:
    print(error, repr(error.__cause__))
"""
    ended = warm_start.run([], program)
    assert ended.stdout.strip() == f"a {error}", ended.stderr


@pytest.mark.parametrize("seed", range(2))
def test_what_was_killed_once_is_done_again(seed, tmp_path):
    hit = random.Random(seed).sample(range(9), 2)  # of three that work, one is left
    tasks = {f"task-{k}": "once" if k in hit else "well" for k in range(9)}
    assert shared_out(tasks, 3, signal.SIGKILL, tmp_path) == [task[::-1] for task in tasks]


def test_where_no_process_can_be_begun_the_work_is_done_here():
    program = """
import os
from rig.report.copies import share_out
def fork():
    raise BlockingIOError
os.fork = fork
print(*share_out(str.upper, ["a", "b", "c"], 2))
"""
    ended = warm_start.run([], program)
    assert ended.stdout.split() == ["A", "B", "C"], ended.stderr


ENDED = """
import contextlib, gc, os, signal, sys, time
from multiprocessing import get_context
from rig.report.copies import begin, end_when_told, ending_quietly
way, parent = sys.argv[1], os.getpid()
def tell_itself():
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.01)
class Kept:
    def __del__(self):
        tell_itself()
def work():
    end_when_told(parent)
    with ending_quietly():
        if way == "dropped":
            Kept()
        if way == "turned":
            try:
                tell_itself()
            except SystemExit:
                raise ImportError("of what is torn") from None
        if way == "taken":
            with contextlib.suppress(SystemExit):
                tell_itself()
        if way == "twice":
            try:
                tell_itself()
            finally:
                tell_itself()
                print("put away", flush=True)
        if way == "together":  # as a terminal that closes and a parent that ends tell it
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM, signal.SIGHUP])
            os.kill(os.getpid(), signal.SIGTERM)
            os.kill(os.getpid(), signal.SIGHUP)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM, signal.SIGHUP])
        if way != "forked":
            time.sleep(60.0)
    print("went on", flush=True)
if way == "forked":  # what a copy's parent hears by must not be heard by the copy as it begins
    def told(*_):
        print("heard by the handler of its parent", flush=True)
    signal.signal(signal.SIGTERM, told)
    os.register_at_fork(after_in_child=tell_itself)
copy = get_context("fork").Process(target=work)
begin(copy)
began = time.monotonic()
copy.join()
print(copy.exitcode, time.monotonic() - began < 30.0)
"""


@pytest.mark.parametrize(
    ("way", "says"),
    [
        ("dropped", []),
        ("turned", []),
        ("taken", []),
        ("twice", ["put away"]),
        ("forked", []),
        ("together", []),
    ],
)
def test_a_copy_that_is_told_ends_soon_and_without_a_word(way, says):
    ended = warm_start.run([way], ENDED)
    assert ended.stderr == ""
    assert ended.stdout.splitlines() == [*says, "0 True"]
