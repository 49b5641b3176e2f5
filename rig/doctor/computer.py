"""The computer itself: kernel, permissions, processors, disk, versions.

References
----------
sched(7), getrlimit(2); the kernel's documentation: admin-guide/pm/cpufreq, pm_qos_interface.
"""

import os
import platform
import resource
import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

from rig.doctor.look import Fitness, Look
from rig.hal.files import how_to_write
from rig.runtime.realtime import timer_slack

KERNEL, REAL_TIME = "kernel", ", PREEMPT_RT"
"""What the line of the kernel is called, and how it says that this one is for real time."""
_LIBRARIES: Final = ("numpy", "scipy", "numba", "python-can", "canopen", "pydantic", "mcap")
_GIBI: Final = 2**30
_MOST_SLACK: Final = 1000
"""ns; a thousandth of a cycle at 1 kHz."""
_LEAST_ROOM: Final = 1.0
"""GiB; an hour of the joint at 1 kHz takes a third of it."""
_SYSTEM: Final = Path("/sys")
_AWAKE: Final = Path("/dev/cpu_dma_latency")
_LIMITS: Final = "/etc/security/limits.conf"


def look_at_computer(folder: Path, priority: int, system: Path = _SYSTEM) -> Iterator[Look]:
    """Yield what there is to say of this computer.

    Parameters
    ----------
    folder : Path
        Where runs are kept; it need not exist yet.
    priority : int
        SCHED_FIFO priority that the loop asks for.
    system : Path
        Where the kernel shows its devices.
    """
    yield _kernel(system)
    yield _scheduling(priority)
    yield _memory()
    yield _waking()
    yield _slack()
    yield _governor(system)
    yield _clock(system)
    yield _disk(folder)
    yield _versions()


def _kernel(system: Path) -> Look:
    release = f"{platform.system()} {platform.release()}"
    if sys.platform != "linux":
        return Look(KERNEL, release, Fitness.NO, "hardware is run on Linux; simulation is not")
    real_time = system / "kernel/realtime"
    if real_time.exists() and real_time.read_text().strip() == "1":
        return Look(KERNEL, f"{release}{REAL_TIME}", Fitness.OK)
    return Look(KERNEL, f"{release}, without PREEMPT_RT", Fitness.OK)


def _scheduling(priority: int) -> Look:
    what = f"SCHED_FIFO at priority {priority}"
    if not priority:
        return Look(what, "the profile does not ask for it", Fitness.OK)
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        mend = f"add to {_LIMITS}: {_user()} - rtprio 99 (and log in anew)"
        return Look(what, f"refused: {error.strerror}", Fitness.POOR, mend)
    os.sched_setscheduler(0, *before)
    return Look(what, "permitted", Fitness.OK)


def _memory() -> Look:
    most, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if most == resource.RLIM_INFINITY or os.geteuid() == 0:
        return Look("locked memory", "permitted", Fitness.OK)
    mend = f"add to {_LIMITS}: {_user()} - memlock unlimited (and log in anew)"
    return Look("locked memory", f"{most / 2**20:.0f} MiB at most", Fitness.POOR, mend)


def _waking() -> Look:
    what = "processors kept awake"
    if os.access(_AWAKE, os.W_OK):
        return Look(what, f"{_AWAKE} can be written", Fitness.OK)
    if not _AWAKE.exists():
        return Look(what, f"there is no {_AWAKE}", Fitness.OK)
    rule = f'KERNEL=="{_AWAKE.name}", GROUP="dialout", MODE="0660"'
    mend = f"echo '{rule}' | sudo tee /etc/udev/rules.d/99-rig.rules && sudo udevadm trigger"
    return Look(what, f"{_AWAKE} cannot be written", Fitness.POOR, mend)


def _slack() -> Look:
    """Return how late sleeps may end: the loop sets it itself, and needs no permission to."""
    if sys.platform != "linux":
        return Look("timer slack", "only Linux has it", Fitness.OK)
    before, least = timer_slack()
    if least <= 0:  # a kernel that is emulated may know no such thing
        return Look("timer slack", "the kernel does not say", Fitness.OK)
    found = f"{before} ns; the loop sets {least} ns while it runs"
    if least > _MOST_SLACK:
        mend = "run on the computer's own kernel: this one keeps sleeps late"
        return Look("timer slack", found, Fitness.POOR, mend)
    return Look("timer slack", found, Fitness.OK)


def _governor(system: Path) -> Look:
    files = sorted(system.glob("devices/system/cpu/cpu[0-9]*/cpufreq/scaling_governor"))
    found = {path.read_text().strip() for path in files}
    if not found:
        return Look("clock of the processors", "the kernel does not change it", Fitness.OK)
    names = ", ".join(sorted(found))
    if found == {"performance"}:
        return Look("clock of the processors", names, Fitness.OK)
    mend = "sudo cpupower frequency-set --governor performance"
    return Look("clock of the processors", names, Fitness.POOR, mend)


def _clock(system: Path) -> Look:
    path = system / "devices/system/clocksource/clocksource0/current_clocksource"
    name = path.read_text().strip() if path.exists() else "not said"
    if name in ("hpet", "acpi_pm", "jiffies"):
        mend = "boot with clocksource=tsc: reading this clock takes a microsecond or more"
        return Look("clock source", name, Fitness.POOR, mend)
    return Look("clock source", name, Fitness.OK)


def _disk(folder: Path) -> Look:
    there = folder.absolute()
    while not there.exists():
        there = there.parent
    what = f"room for runs in {there}"
    if not os.access(there, os.W_OK):
        mend = f"{how_to_write(there)}; or another folder: --out FOLDER"
        return Look(what, "may not be written", Fitness.NO, mend)
    free = shutil.disk_usage(there).free / _GIBI
    if free < _LEAST_ROOM:
        mend = "remove old runs: rig list runs shows them"
        return Look(what, f"{free:.2f} GiB", Fitness.NO, mend)
    return Look(what, f"{free:.0f} GiB", Fitness.OK)


def _versions() -> Look:
    found, missing = [f"Python {platform.python_version()}"], []
    for name in _LIBRARIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    if missing:
        mend = f"{sys.executable} -m pip install {' '.join(missing)}"
        return Look("versions", f"without {', '.join(missing)}", Fitness.NO, mend)
    return Look("versions", ", ".join(found), Fitness.OK)


def _user() -> str:
    import pwd

    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())
