"""Who waits is told of it, by nobody who is there when the waiting is over."""

import logging
import os
import threading

import pytest

from rig.cli import patience
from rig.cli.progress import ProgressLine


def test_nobody_is_left_when_it_is_over(monkeypatch):
    monkeypatch.setattr(patience, "is_terminal", lambda stream: True)
    before = threading.active_count()
    for _ in range(50):
        with patience.told_if_long("waiting"):
            assert threading.active_count() == before + 1
        assert threading.active_count() == before


def test_compiling_is_said_once_and_only_meanwhile(capsys):
    logger = logging.getLogger("controllers.kernel_files")
    before = logger.level, logger.propagate, list(logger.handlers)
    with patience.told_of_compiling():
        logger.info("compiling kernels")
        logger.info("compiling kernels")
    logger.info("compiling kernels")
    assert capsys.readouterr() == ("", "compiling kernels …\n")
    assert (logger.level, logger.propagate, list(logger.handlers)) == before


def test_a_copy_says_nothing_of_what_it_compiles(capfd):
    with patience.told_of_compiling():
        if (copy := os.fork()) == 0:
            logging.getLogger("controllers.kernel_files").info("compiling kernels")
            os._exit(0)
        os.waitpid(copy, 0)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("size", "said"), [(10, ""), (64 << 20, "drawing …\n")])
def test_a_pipe_is_told_of_a_long_log_alone(size, said, tmp_path, capsys):
    with (tmp_path / "log.mcap").open("wb") as log:
        log.truncate(size)
    with patience.told_of_log("drawing", tmp_path / "log.mcap"):
        assert capsys.readouterr() == ("", said)
    with patience.told_of_log("drawing", tmp_path / "none"):
        assert capsys.readouterr() == ("", "")


def test_a_terminal_is_told_until_it_is_done(tmp_path, monkeypatch):
    ours, theirs = os.openpty()
    with os.fdopen(theirs, "w") as terminal:
        monkeypatch.setattr("sys.stderr", terminal)
        with patience.told_of_log("drawing", tmp_path / "none"):
            assert os.read(ours, 100) == "\r\x1b[2Kdrawing …".encode()
        assert os.read(ours, 100) == b"\r\x1b[2K"
        with ProgressLine("step", "sim") as line:
            line.working("measuring")
            assert os.read(ours, 100) == "\r\x1b[2Kmeasuring …".encode()
    os.close(ours)


def test_a_pipe_is_told_of_what_comes_after_a_run(capsys):
    with ProgressLine("step", "sim") as line:
        line.working("measuring")
    assert capsys.readouterr() == ("", "measuring …\n")
