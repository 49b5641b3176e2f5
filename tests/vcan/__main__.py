"""Run the tests marked ``vcan`` where there is SocketCAN: ``python tests/vcan [OPTIONS]``.

Natively if this kernel makes virtual CAN interfaces, else inside Debian's user-mode Linux: a
kernel that runs as an ordinary process, with the host's files as its own (packages
``user-mode-linux``, ``kmod`` and ``iproute2``; no virtualisation, no privilege beyond root's; or
the newer one that ``.ci/user-mode-linux`` gets, which boots on every processor).
It takes a second to boot. It has one processor and slow system calls: it is for function, not
for timing. Where no tests are named each file has a kernel of its own, two at a time if there are
two processors; what a file said is shown when it has ended.

The exit code is pytest's, the largest if there are several, or 4 if there is neither kernel, and
124 if the time was up.
"""

import os
import subprocess
import sys
from pathlib import Path

from each_file import PROCESSOR, each_file
from user_mode_linux import SCRATCH, CannotBoot, NotInstalled, run_inside
from vcan_links import LINKS, make_links, missing

TIME_LIMIT = float(os.environ.get("VCAN_TIME_LIMIT", "1800"))  # of one kernel, s
_NEITHER = 4  # pytest's own code for a usage error
_CANNOT_BOOT = 6  # none of pytest's
_ROOT = Path(__file__).parents[2]
_PATIENT_TIME = Path(__file__).parent / "patient_time"


def main() -> int:
    """Run the tests wherever they can be run; return the exit code."""
    arguments = sys.argv[1:]
    if not names_tests(arguments) and not os.environ.get("SLOW"):
        arguments = ["-m", "vcan and not slow", *arguments]
    command = [
        sys.executable, "-m", "pytest", "-m", "vcan", "-n", "0", "-p", "no:cacheprovider",
        *arguments, *([] if names_tests(arguments) else [str(Path(__file__).parent)]),
    ]  # fmt: skip
    reason = make_links()
    if reason is None:
        say(f"on this kernel's {', '.join(LINKS)}")
        os.chdir(_ROOT)
        os.execv(command[0], command)
    say(f"{reason}; in user-mode Linux instead")
    processors = os.sched_getaffinity(0)
    if len(processors) > 1 and not names_tests(arguments) and PROCESSOR not in os.environ:
        return each_file(arguments, sorted(processors)[-2:])
    processor = int(os.environ.get(PROCESSOR, max(processors)))
    try:
        code = run_inside([*command, f"--basetemp={SCRATCH}/pytest"], _ROOT, TIME_LIMIT, processor)
    except NotInstalled as error:
        say(str(error))
        return _NEITHER
    except CannotBoot as error:
        say(str(error))
        return _CANNOT_BOOT
    if code is None:
        say(f"ended after {TIME_LIMIT:g} s (VCAN_TIME_LIMIT)")
        return 124
    return code


def names_tests(arguments: list[str]) -> bool:
    """Return whether some of pytest's arguments say which tests."""
    return any(Path(argument.partition("::")[0]).exists() for argument in arguments)


def say(text: str) -> None:
    """Tell the user something."""
    sys.stderr.write(f"tests.vcan: {text}\n")
    sys.stderr.flush()


def inside(command: list[str]) -> int:
    """Run a command once the interfaces are up; what user-mode Linux's first process calls.

    It and the programs that it starts share a time of their own, see `patient_time`.
    """
    reason = make_links()
    if reason is not None:
        say(f"inside user-mode Linux: {reason}, {missing()}")
        return _NEITHER
    sys.path.append(str(_PATIENT_TIME))
    from shared_time import create_time

    folder = Path(SCRATCH, "time")
    create_time(folder)
    Path("/proc/sys/kernel/sched_rt_runtime_us").write_text("-1")  # all of the processor
    _deliver_first()
    keeper = [sys.executable, str(_PATIENT_TIME / "time_keeper.py"), str(folder)]
    with subprocess.Popen(keeper) as keeping:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        try:
            return subprocess.call(command, env={**os.environ, "SHARED_TIME": str(folder)})
        finally:
            keeping.kill()


def _deliver_first() -> None:
    """Have frames on their way delivered before any program goes on.

    A kernel that was paused by its host leaves them to a thread of its own, which is as low as
    the rest: the programs' time would pass while frames wait for it.
    """
    for entry in Path("/proc").glob("[0-9]*/comm"):
        if entry.read_text().startswith("ksoftirqd"):
            os.sched_setscheduler(int(entry.parent.name), os.SCHED_FIFO, os.sched_param(90))


if __name__ == "__main__":
    sys.exit(inside(sys.argv[2:]) if sys.argv[1:2] == ["--inside"] else main())
