"""A sweep whose points take a few milliseconds: what is tested is what stands around them.

``python sweep_stub.py OUT WORKERS POINTS [DASK|loud]`` runs it, as `rig sweep` would.
"""

import os
import signal
import sys
import time
from pathlib import Path

CONFIGS = Path(os.environ.get("SWEEP_STUB_CONFIGS", Path(__file__).parents[2] / "configs"))
SPENT = float(os.environ.get("SWEEP_STUB_SECONDS", "0.01"))


def perform(job):
    """Return what would be a run's; every fifth point fails, the name alone says which."""
    time.sleep(SPENT)
    number = int(job.name[:12], 16)
    if number % 5 == 0:
        return {
            "point": job.name, "status": "faulted", "reason": f"fell, at {number}", "metrics": []
        }  # fmt: skip
    return {
        "point": job.name, "status": "ok", "reason": "",
        "metrics": [{"name": "rise_time", "value": number / 7e14, "unit": "m", "bound": 0.2,
                     "kind": "max"}],
    }  # fmt: skip


def dies(job):
    """Kill the worker at some points, each time."""
    if int(job.name[:12], 16) % 5 == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return perform(job)


def fills_the_disk(job):
    """Run a point whose log cannot be written to its end."""
    from rig.experiment.ending import EXIT_FAULT
    from rig.experiment.run import Result
    from rig.run_facts import RunStatus
    from rig.sweeping import point

    def cut_off(plan, backend, out, **more):
        what = f"cannot write {out / 'some-run' / 'log.mcap'}: No space left on device; it ends"
        return Result(out, RunStatus.FAULTED, EXIT_FAULT, what, ())

    point.run_experiment = cut_off
    return point.perform(job)


def sweep(out, workers, count, dask=None, what="perform", quiet=True, **more):
    from rig.sweeping.axis import parse_axis, parse_seeds
    from rig.sweeping.progress import SweepProgress
    from rig.sweeping.request import SweepRequest
    from rig.sweeping.run import run_sweep

    request = SweepRequest(
        "cylinder-step", (parse_axis("plant.friction_scale=0.5,1"),),
        parse_seeds(f"0:{count // 2}"),
        on="sim", workers=int(workers), dask=dask, out=Path(out), configs=CONFIGS, **more,
    )  # fmt: skip
    return run_sweep(request, lambda n: SweepProgress(n, quiet=quiet), f"sweep_stub:{what}")


if __name__ == "__main__":
    out, workers, count, *more = sys.argv[1:]
    sys.path.insert(0, str(Path(__file__).parent))
    loud = more == ["loud"]
    sweep(out, workers, int(count), *([] if loud else more), quiet=not loud)
