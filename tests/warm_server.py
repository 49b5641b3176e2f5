"""Forks a process for each program that `warm_start` asks for: everything is imported already.

What is forked has nothing of the tests: only the modules of this process, which ran none of them.
"""

import contextlib
import fcntl
import importlib
import json
import os
import selectors
import socket
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

_LONGEST = 1 << 18
"""Of a request, bytes."""
_MOST = 8
"""Files that it hands over."""
_BEYOND = 256
"""No file of this process has this number."""


def serve(requests: socket.socket) -> Callable[[], None]:
    """Start what is asked for until nobody can ask any more.

    Returns
    -------
    callable
        In each process that is forked: the program. Nothing of this one is on its stack, so that
        it ends as any other does.
    """
    selector = selectors.DefaultSelector()
    selector.register(requests, selectors.EVENT_READ)
    while True:
        for key, _ in selector.select():
            if key.fileobj is not requests:
                _tell_end(selector, key)
                continue
            text, ends, *_ = socket.recv_fds(requests, _LONGEST, _MOST)
            if not text:
                sys.exit()
            *streams, told = ends
            if (pid := os.fork()) == 0:
                streams = [fcntl.fcntl(stream, fcntl.F_DUPFD, _BEYOND) for stream in streams]
                requests.detach()
                selector.close()
                return partial(_become, json.loads(text), streams)
            for stream in streams:
                os.close(stream)
            with contextlib.suppress(BrokenPipeError):
                os.write(told, b"%d\n" % pid)
            selector.register(os.pidfd_open(pid), selectors.EVENT_READ, (pid, told))


def _tell_end(selector: selectors.BaseSelector, key: selectors.SelectorKey) -> None:
    """Say with what code a process has ended."""
    pid, told = key.data
    selector.unregister(key.fileobj)
    os.close(key.fd)
    _, status = os.waitpid(pid, 0)
    with contextlib.suppress(BrokenPipeError):  # nobody waits for it any more
        os.write(told, b"%d\n" % os.waitstatus_to_exitcode(status))
    os.close(told)


def _become(asked: dict, streams: list[int]) -> None:
    """Run a program as Python runs one that it has just been started with."""
    os.closerange(3, _BEYOND)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    paths = asked["environment"].get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:] = ["", *filter(None, paths), *sys.path]
    importlib.invalidate_caches()
    sys.argv[1:] = asked["words"]
    exec(compile(asked["program"], "<string>", "exec"), {"__name__": "__main__"})


if __name__ == "__main__":
    server = socket.socket(fileno=int(sys.argv[1]))
    sys.path[0] = str(Path(__file__).parent / "vcan")
    importlib.import_module("all_of_rig")
    del sys.path[0]
    serve(server)()
