"""A copy of the process gets ready during a run: its report is that of the process itself."""

import os
import signal
import time

import pytest
import warm_start

WRITE = """
import os, signal, sys, time
from pathlib import Path
from rig.report import ready
from rig.report.ready import ReadyReporter
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job may ignore it
run, way = Path(sys.argv[1]), sys.argv[2]
at_hand = ready.written
def written(path):
    if way == "fails":
        raise ZeroDivisionError
    if way == "waits":
        os.kill(os.getppid(), signal.SIGINT)
        time.sleep(60.0)
    if way == "orphaned":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60.0)
    print(os.getpid(), flush=True)
    return at_hand(path)
ready.written = written
with ReadyReporter(ahead=way != "late") as reporter:
    copy = getattr(reporter, "_copy", None)
    print(os.getpid(), copy is not None and copy.pid, flush=True)
    if way == "killed":
        os.kill(copy.pid, signal.SIGKILL)
    if way != "unasked":
        print(*reporter.write(run), sep="; ")
print(copy is None or not copy.is_alive())
"""


@pytest.fixture
def write(make_run):
    if len(os.sched_getaffinity(0)) < 2:
        pytest.skip("this machine has one processor")
    run = make_run(duration=1.0)

    def written(way):
        for path in (run / "figures").glob("*"):
            path.unlink()
        ended = warm_start.run([run, way], WRITE)
        figures = {path.name: path.read_bytes() for path in (run / "figures").glob("*")}
        return ended, ended.stdout.split("\n")[:-1], figures

    return written


def test_a_copy_writes_what_the_process_writes(write):
    _, (ids, writer, lacks, _), figures = write("late")
    assert writer == ids.split()[0]
    _, (ids, writer, same, has_ended), of_copy = write("ahead")
    assert writer == ids.split()[1]  # else nobody was ready
    assert (same, has_ended) == (lacks, "True")
    assert figures
    assert of_copy == figures


def test_a_copy_that_was_killed_takes_no_report_with_it(write):
    ended, (ids, writer, *_), figures = write("killed")
    assert ended.returncode == 0, ended.stderr
    assert writer == ids.split()[0]
    assert figures


def test_a_copy_that_fails_hides_no_bug(write):
    ended, *_ = write("fails")
    assert ended.returncode == 1
    assert ended.stderr.rstrip().endswith("ZeroDivisionError")


def test_a_copy_that_nobody_asks_ends(write):
    _, (_, has_ended), figures = write("unasked")
    assert has_ended == "True"
    assert not figures


def test_who_does_not_wait_for_the_report_leaves_no_copy_behind(write):
    ended, (ids, *_), _ = write("waits")
    assert "KeyboardInterrupt" in ended.stderr
    with pytest.raises(ProcessLookupError):
        os.kill(int(ids.split()[1]), 0)


def test_a_copy_ends_without_a_word_when_its_process_is_killed(write):
    ended, (ids, *said), _ = write("orphaned")
    assert (ended.returncode, ended.stderr, said) == (-signal.SIGKILL, "", [])
    until = time.monotonic() + 30.0
    with pytest.raises(ProcessLookupError):
        while time.monotonic() < until:
            os.kill(int(ids.split()[1]), 0)
            time.sleep(0.02)
