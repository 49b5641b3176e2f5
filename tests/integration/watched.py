"""A run in real time with its page, for tests of what looks at it and who may."""

import contextlib
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple

from rig.stopping import request_stop

LOCAL = "127.0.0.1"


class Watched(NamedTuple):
    """A run that goes on, and the addresses of its page."""

    process: subprocess.Popen
    folder: Path
    look: str
    steer: str | None

    @property
    def port(self) -> int:
        return int(re.search(r":(\d+)/", self.look)[1])

    @property
    def token(self) -> str:
        return self.look.partition("#")[2]


class _Talk:
    """What a process says on stderr, read as it comes."""

    def __init__(self, stream) -> None:
        self.text = ""
        self._stream = stream
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        for line in self._stream:
            self.text += line

    def wait_for(self, pattern: str, process, timeout: float = 90.0) -> str:
        until = time.monotonic() + timeout
        while time.monotonic() < until:
            if found := re.search(pattern, self.text, re.MULTILINE):
                return found[1]
            if process.poll() is not None and process.returncode:
                break
            time.sleep(0.02)
        raise AssertionError(f"{pattern} was not said: {self.text}")

    def close(self) -> None:
        self._thread.join(10)
        self._stream.close()


@contextlib.contextmanager
def watched_run(out: Path, *arguments: str, steer: bool = True):
    """Yield a run that goes on with its page; whatever of it is left in the end is ended."""
    options = ["--watch", *(["--steer"] if steer else []), "--no-report", "--out", str(out)]
    command = [sys.executable, "-m", "rig", "run", *arguments, *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    talk = _Talk(process.stderr)
    server = None
    try:
        folder = Path(talk.wait_for(r"recording to (.+)$", process))
        look = talk.wait_for(r"^watch .*: (http://.+)$", process)
        asked = talk.wait_for(r"^steer it: (http://.+)$", process) if steer else None
        server = server_of(folder)
        yield Watched(process, folder, look, asked)
    finally:
        with contextlib.suppress(Exception):
            request_stop(folder, at_once=True)
        process.wait(30)
        if server is not None:
            subprocess.run(["kill", str(server)], check=False)
        talk.close()


@contextlib.contextmanager
def served_folder(folder: Path, *arguments: str):
    """Yield the address of the page of a run that has ended, or from which it is steered."""
    command = [sys.executable, "-m", "rig", "watch", str(folder), "--port", "0", *arguments]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    talk = _Talk(process.stderr)
    which = "steer it" if "--steer" in arguments else "watch .*"
    try:
        yield talk.wait_for(rf"^{which}: (http://.+)$", process)
    finally:
        process.terminate()
        process.wait(30)
        talk.close()


@contextlib.contextmanager
def paced_run(out: Path, *arguments: str):
    """Yield the folder of a run that goes on in real time, and that nobody watches."""
    arguments = arguments or ("cylinder-sine", "--on", "sim")
    command = [sys.executable, "-m", "rig", "run", *arguments, "--pace", "1"]
    process = subprocess.Popen(
        [*command, "--no-report", "--out", str(out)], stderr=subprocess.PIPE, text=True
    )
    talk = _Talk(process.stderr)
    try:
        folder = Path(talk.wait_for(r"recording to (.+)$", process))
        talk.wait_for(r"^(run …)$", process)
        yield folder
    finally:
        process.terminate()
        process.wait(30)
        talk.close()


def server_of(folder: Path) -> int:
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            words = entry.read_bytes().split(b"\0")
            if b"watch" in words and str(folder).encode() in words:
                return int(entry.parent.name)
    raise AssertionError("nobody serves the page")
