"""A rig in two processes: one simulates it, the other runs an experiment on it."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RIG = (sys.executable, "-m", "rig")
IN_USER_MODE_LINUX = "hostfs" in Path("/proc/cmdline").read_text()
SHARED_TIME = os.environ.get("SHARED_TIME")
"""Where the programs' own time is, if they have one; see `patient_time`."""
PATIENCE = 600.0 if IN_USER_MODE_LINUX else 60.0
"""For a program to start, or to end, s: it is only ever used up by one that hangs."""
if SHARED_TIME:
    sys.path.append(str(HERE / "patient_time"))
    from shared_time import SharedTime
    from warm_programs import WarmProcess

    os.environ["PYTHONPATH"] = os.pathsep.join(map(str, (HERE / "patient_time", HERE, ROOT)))
    _time = SharedTime(Path(SHARED_TIME))
    now, pause = _time.now, _time.sleep
else:
    now, pause = time.monotonic, time.sleep


def start(arguments, environment):
    """Start a `rig` command."""
    if SHARED_TIME:
        return WarmProcess(arguments, environment)
    watched = (sys.executable, str(HERE / "watched_rig.py"))
    return subprocess.Popen(
        [*(watched if "WATCHED_TRUTH" in environment else RIG), *arguments],
        cwd=ROOT,
        env={**os.environ, **environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


class Program:
    """A `rig` command in a process of its own."""

    def __init__(self, *arguments, environment=None):
        self.process = start([*map(str, arguments)], environment or {})
        self.said, self.printed = [], []
        self._more = threading.Condition()
        self._readers = [
            threading.Thread(target=self._read, args=(stream, kept), daemon=True)
            for stream, kept in (
                (self.process.stderr, self.said),
                (self.process.stdout, self.printed),
            )
        ]
        for reader in self._readers:
            reader.start()

    def _read(self, stream, kept):
        for line in stream:
            with self._more:
                kept.append(line.rstrip("\n"))
                self._more.notify_all()
        with self._more:
            self._more.notify_all()

    def wait_for(self, words):
        """Return the first line of its talk with these words."""

        def found():
            return next((line for line in self.said if words in line), None)

        with self._more:
            self._more.wait_for(lambda: found() or self.process.poll() is not None, PATIENCE)
            line = found()
        assert line, f"it did not say {words!r} but: {self.said}"
        return line

    def send(self, number):
        self.process.send_signal(number)

    def end(self):
        """Wait until it has ended; return its exit code."""
        code = self.process.wait(PATIENCE)
        for reader in self._readers:
            reader.join(PATIENCE)
        for stream in (self.process.stdout, self.process.stderr):
            stream.close()
        return code

    def stop(self):
        """Have it end as Ctrl-C does; return its exit code."""
        self.send(signal.SIGINT)
        return self.end()

    @property
    def talk(self):
        return "\n".join(self.said)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.end()


def simulate(rig, on, *more, truth=None):
    """Start the simulation of a rig; it is ready when this returns.

    What was true is written to the file `truth` at its end, if there is to be one.
    """
    environment = {} if truth is None else {"WATCHED_TRUTH": str(truth)}
    program = Program("simulate", rig, "--on", on, *more, environment=environment)
    program.wait_for("simulating ")
    return program


def set_all(**values):
    """Return the options for settings; a double underscore stands for a dot."""
    options = (f"{key.replace('__', '.')}={value}" for key, value in values.items())
    return tuple(word for option in options for word in ("--set", option))


def only_run(out):
    """Return the manifest of the only run in a folder, and that folder."""
    (folder,) = [path for path in Path(out).iterdir() if path.is_dir()]
    return json.loads((folder / "manifest.json").read_text()), folder
