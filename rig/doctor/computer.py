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

from rig.doctor.finding import Finding, Verdict

_LIBRARIES: Final = ("numpy", "scipy", "numba", "python-can", "canopen", "pydantic", "mcap")
_GIBI: Final = 2**30
_LEAST_ROOM: Final = 1.0
"""GiB; an hour of the joint at 1 kHz takes a third of it."""
_SYSTEM: Final = Path("/sys")
_AWAKE: Final = Path("/dev/cpu_dma_latency")
_LIMITS: Final = "/etc/security/limits.conf"


def look_at_computer(folder: Path, priority: int, system: Path = _SYSTEM) -> Iterator[Finding]:
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
    yield _governor(system)
    yield _clock(system)
    yield _disk(folder)
    yield _versions()


def _kernel(system: Path) -> Finding:
    release = f"{platform.system()} {platform.release()}"
    if sys.platform != "linux":
        return Finding("kernel", release, Verdict.NO, "hardware is run on Linux; simulation is not")
    real_time = system / "kernel/realtime"
    if real_time.exists() and real_time.read_text().strip() == "1":
        return Finding("kernel", f"{release}, PREEMPT_RT", Verdict.OK)
    return Finding("kernel", f"{release}, without PREEMPT_RT", Verdict.OK)


def _scheduling(priority: int) -> Finding:
    what = f"SCHED_FIFO at priority {priority}"
    if not priority:
        return Finding(what, "the profile does not ask for it", Verdict.OK)
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        mend = f"add to {_LIMITS}: {_user()} - rtprio 99 (and log in anew)"
        return Finding(what, f"refused: {error.strerror}", Verdict.POOR, mend)
    os.sched_setscheduler(0, *before)
    return Finding(what, "permitted", Verdict.OK)


def _memory() -> Finding:
    most, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if most == resource.RLIM_INFINITY or os.geteuid() == 0:
        return Finding("locked memory", "permitted", Verdict.OK)
    mend = f"add to {_LIMITS}: {_user()} - memlock unlimited (and log in anew)"
    return Finding("locked memory", f"{most / 2**20:.0f} MiB at most", Verdict.POOR, mend)


def _waking() -> Finding:
    what = "processors kept awake"
    if os.access(_AWAKE, os.W_OK):
        return Finding(what, f"{_AWAKE} can be written", Verdict.OK)
    if not _AWAKE.exists():
        return Finding(what, f"there is no {_AWAKE}", Verdict.OK)
    rule = f'KERNEL=="{_AWAKE.name}", GROUP="dialout", MODE="0660"'
    mend = f"echo '{rule}' | sudo tee /etc/udev/rules.d/99-rig.rules && sudo udevadm trigger"
    return Finding(what, f"{_AWAKE} cannot be written", Verdict.POOR, mend)


def _governor(system: Path) -> Finding:
    files = sorted(system.glob("devices/system/cpu/cpu[0-9]*/cpufreq/scaling_governor"))
    found = {path.read_text().strip() for path in files}
    if not found:
        return Finding("clock of the processors", "the kernel does not change it", Verdict.OK)
    names = ", ".join(sorted(found))
    if found == {"performance"}:
        return Finding("clock of the processors", names, Verdict.OK)
    mend = "sudo cpupower frequency-set --governor performance"
    return Finding("clock of the processors", names, Verdict.POOR, mend)


def _clock(system: Path) -> Finding:
    path = system / "devices/system/clocksource/clocksource0/current_clocksource"
    name = path.read_text().strip() if path.exists() else "not said"
    if name in ("hpet", "acpi_pm", "jiffies"):
        mend = "boot with clocksource=tsc: reading this clock takes a microsecond or more"
        return Finding("clock source", name, Verdict.POOR, mend)
    return Finding("clock source", name, Verdict.OK)


def _disk(folder: Path) -> Finding:
    there = folder.absolute()
    while not there.exists():
        there = there.parent
    what = f"room for runs in {there}"
    if not os.access(there, os.W_OK):
        mend = f"sudo chown {_user()} {there}, or another folder: --out FOLDER"
        return Finding(what, "may not be written", Verdict.NO, mend)
    free = shutil.disk_usage(there).free / _GIBI
    if free < _LEAST_ROOM:
        mend = "remove old runs: rig list runs shows them"
        return Finding(what, f"{free:.2f} GiB", Verdict.NO, mend)
    return Finding(what, f"{free:.0f} GiB", Verdict.OK)


def _versions() -> Finding:
    found, missing = [f"Python {platform.python_version()}"], []
    for name in _LIBRARIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            missing.append(name)
    if missing:
        mend = f"{sys.executable} -m pip install {' '.join(missing)}"
        return Finding("versions", f"without {', '.join(missing)}", Verdict.NO, mend)
    return Finding("versions", ", ".join(found), Verdict.OK)


def _user() -> str:
    import pwd

    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())
