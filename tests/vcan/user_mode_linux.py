"""Debian's user-mode Linux as a place to run one command in."""

import contextlib
import ctypes
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

_MEMORY = "2048M"  # a file of the host, of which it takes what it needs
_NEWER = Path("/opt/user-mode-linux")
"""Where ``.ci/user-mode-linux`` puts a kernel that is newer than the distribution's."""
_PR_SET_PDEATHSIG = 1
SCRATCH = "/dev/shm"
"""A folder in the guest's own memory: what is written there need not wait for the host."""
_MODULES = (
    "net/can/can",
    "net/can/can-raw",
    "net/can/can-bcm",
    "drivers/net/can/dev/can-dev",
    "drivers/net/can/vcan",
    "drivers/net/can/vxcan",
    "drivers/net/can/slcan/slcan",
    "net/sched/sch_plug",
)
# What the first process does. The root is the host's: what this writes, the host keeps.
_FIRST_PROCESS = """\
#!/bin/sh
: >{place}/begun
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devpts devpts /dev/pts 2>/dev/null
mkdir -p {scratch} && mount -t tmpfs tmpfs {scratch}
cd {modules_of}/$(uname -r)/kernel
for module in {modules}; do {insmod} $module.ko; done
{ip} link set lo up
cd {folder}
{environment}
{command} </dev/null >{place}/out 2>&1
echo $? >{place}/code
sleep 60  # the kernel is ended from outside
"""
# A kernel that has no more to do with the host's hardware than its files must not look for it.
_KEPT = ("HOME", "PATH", "LANG", "VIRTUAL_ENV", "PYTHONPATH", "NUMBA_CACHE_DIR", "MPLBACKEND")


@dataclass(frozen=True)
class _Kernel:
    """One that is installed: its program, the folder of its modules, its own options."""

    program: str
    modules: Path
    options: tuple[str, ...] = ()


class NotInstalled(Exception):
    """User-mode Linux, or a tool that it needs, is not on this machine."""


class CannotBoot(Exception):
    """User-mode Linux died before its first process did anything."""


def run_inside(command: list[str], folder: Path, time_limit: float, processor: int) -> int | None:
    """Run a command inside; its output comes through as it is written.

    Parameters
    ----------
    command : list of str
        Its first word is an absolute path. It runs by way of this folder's ``__main__``, which
        sets the interfaces up.
    folder : Path
        Where it runs.
    time_limit : float
        After this the kernel is ended, s.
    processor : int
        Of the host, on which it runs.

    Returns
    -------
    int or None
        The command's exit code; None if the time was up.

    Raises
    ------
    NotInstalled
        With the command that installs it.
    CannotBoot
        This machine's processor cannot run it.
    """
    kernels = _installed()
    insmod = shutil.which("insmod") or shutil.which("insmod", path="/sbin:/usr/sbin")
    ip = shutil.which("ip") or shutil.which("ip", path="/sbin:/usr/sbin")
    if not (kernels and insmod and ip):
        raise NotInstalled(
            "user-mode Linux is not installed: apt-get install user-mode-linux kmod iproute2"
        )
    _round_times(folder)
    signal.signal(signal.SIGTERM, _end_with)
    inside = shlex.join([command[0], str(Path(__file__).parent), "--inside", *command])
    for kernel in kernels:
        with tempfile.TemporaryDirectory(prefix="vcan-") as name:
            place = Path(name)
            first = place / "init"
            first.write_text(
                _FIRST_PROCESS.format(
                    place=place,
                    modules_of=kernel.modules,
                    modules=" ".join(_MODULES),
                    insmod=insmod,
                    ip=ip,
                    scratch=SCRATCH,
                    folder=shlex.quote(str(folder)),
                    environment="\n".join(
                        f"export {key}={shlex.quote(os.environ[key])}"
                        for key in _KEPT
                        if key in os.environ
                    ),
                    command=inside,
                ),
                encoding="utf-8",
            )
            first.chmod(0o755)
            booted = _boot(kernel, place, time_limit, processor)
            if booted:
                code = place / "code"
                return int(code.read_text()) if code.exists() and code.stat().st_size else None
    raise CannotBoot(
        "user-mode Linux dies on this processor before its first process: Debian's 6.1 saves less "
        "of a processor's state than some have (those with AMX); .ci/user-mode-linux gets a newer"
    )


def _installed() -> list[_Kernel]:
    """Return the kernels of this machine, the newest first."""
    newer = shutil.which("linux.uml", path=str(_NEWER))
    own = shutil.which("linux.uml") or shutil.which("linux")
    # Processes that help their kernel need a tenth of the time for a system call.
    return [
        *([_Kernel(newer, _NEWER / "modules", ("seccomp=auto",))] if newer else []),
        *([_Kernel(own, Path("/usr/lib/uml/modules"))] if own else []),
    ]


def _boot(kernel: _Kernel, place: Path, time_limit: float, processor: int) -> bool:
    """Run what is in this folder to its end, or that of the time; return whether it began."""
    out = place / "out"
    out.touch()
    booted = subprocess.Popen(
        [
            kernel.program, f"mem={_MEMORY}", "rootfstype=hostfs", "rootflags=/", "rw", "quiet",
            f"init={place / 'init'}", "con=null", "con0=null", f"umid=vcan-{os.getpid()}",
            *kernel.options,
        ],
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=_die_with_parent,  # noqa: PLW1509 - this program has one thread
    )  # fmt: skip
    _come_first(booted.pid, processor)
    try:
        _follow(booted, out, place / "code", time_limit)
        died = booted.poll() is not None
    finally:
        # All of its processes are in a session of their own, the guest's programs too.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(booted.pid, signal.SIGKILL)
        booted.wait()
    return not died or (place / "begun").exists()


def _round_times(folder: Path) -> None:
    """Have the kernel inside tell the same times of our sources as the one outside.

    It knows whole seconds only, and compiled functions are kept with the time of their source:
    each kernel would compile all of them again after the other.
    """
    for package in ("controllers", "drivers", "rig"):
        for path in (folder / package).rglob("*.py"):
            seconds = int(path.stat().st_mtime)
            os.utime(path, (seconds, seconds))


def _come_first(pid: int, processor: int) -> None:
    """Have the kernel run before everything else on this processor of the host, if permitted.

    Real-time tests inside must not fail because something else is busy outside. The guest's one
    processor sleeps whenever its programs do. It is several processes, of which one works at a
    time: spread over processors that are idle, half of the time goes into waking them.
    """
    with contextlib.suppress(OSError):
        os.sched_setaffinity(pid, {processor})
    with contextlib.suppress(OSError):
        os.sched_setscheduler(pid, os.SCHED_FIFO, os.sched_param(1))


def _follow(booted: "subprocess.Popen[bytes]", out: Path, code: Path, time_limit: float) -> None:
    """Show what is written until the command or the kernel has ended, or the time is up."""
    deadline = monotonic() + time_limit
    with out.open("rb") as written:
        while True:
            ended = booted.poll() is not None or (code.exists() and code.stat().st_size > 0)
            text = written.read()
            if text:
                sys.stdout.buffer.write(text)
                sys.stdout.flush()
            if ended or monotonic() > deadline:
                return
            sleep(0.1)


def _end_with(signal_number: int, _frame: object) -> None:
    """Leave by way of all the ``finally`` when this program is asked to end."""
    sys.exit(128 + signal_number)


def _die_with_parent() -> None:
    """Have the kernel end even if this program is killed."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
