"""Hardware-in-the-loop rig controller: one program for a lab's research rigs.

From Python::

    import rig

    run = rig.run("cylinder-sine", on="sim", seed=3)
    print(run.metrics)
    run.figure("tracking")

What is offered here is imported when it is used first.
"""

import importlib
import os
from typing import TYPE_CHECKING

from rig.arithmetic import round_alike

round_alike()

# Images are somebody's files, and one of a megabyte may say that it has a thousand million pixels.
# OpenCV asks once, when it is imported: 8000 by 8000 are enough.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(1 << 26))

if TYPE_CHECKING:
    from rig.hal import (
        ConfigurationError,
        DeviceError,
        RigError,
        SafetyError,
    )
    from rig.runtime.log_tail import LogTail
    from rig.runtime.stop import StopRequests
    from rig.scripting.calibrating import calibrate
    from rig.scripting.checking import check
    from rig.scripting.comparing import compare
    from rig.scripting.errors import (
        BoundMissed,
        CodeFailed,
        MeasureFailed,
        NotEnergised,
        RunError,
        RunFaulted,
        RunInterrupted,
    )
    from rig.scripting.recorded import Run
    from rig.scripting.replaying import replay
    from rig.scripting.running import load, run, runs
    from rig.sweeping.api import sweep
    from rig.sweeping.result import SweepInterrupted

_ENDS = (
    "RunError", "BoundMissed", "CodeFailed", "MeasureFailed", "NotEnergised", "RunFaulted",
    "RunInterrupted",
)  # fmt: skip
_OFFERED = {
    **dict.fromkeys(("run", "load", "runs"), "rig.scripting.running"),
    "Run": "rig.scripting.recorded",
    "check": "rig.scripting.checking",
    "calibrate": "rig.scripting.calibrating",
    "compare": "rig.scripting.comparing",
    "replay": "rig.scripting.replaying",
    "sweep": "rig.sweeping.api",
    "SweepInterrupted": "rig.sweeping.result",
    "LogTail": "rig.runtime.log_tail",
    "StopRequests": "rig.runtime.stop",
    **dict.fromkeys(_ENDS, "rig.scripting.errors"),
    **dict.fromkeys(("RigError", "ConfigurationError", "DeviceError", "SafetyError"), "rig.hal"),
}

__all__ = [
    "BoundMissed",
    "CodeFailed",
    "ConfigurationError",
    "DeviceError",
    "LogTail",
    "MeasureFailed",
    "NotEnergised",
    "RigError",
    "Run",
    "RunError",
    "RunFaulted",
    "RunInterrupted",
    "SafetyError",
    "StopRequests",
    "SweepInterrupted",
    "calibrate",
    "check",
    "compare",
    "load",
    "replay",
    "run",
    "runs",
    "sweep",
]


def __getattr__(name: str) -> object:
    if name not in _OFFERED:
        raise AttributeError(f"module 'rig' has no attribute {name!r}")
    importlib.import_module("rig.kernel_cache").keep_kernels()
    found: object = getattr(importlib.import_module(_OFFERED[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_OFFERED})
