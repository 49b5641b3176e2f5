"""What a Dask worker does with a point: a warm process of its own runs it, as on any machine.

A point that crashes takes no Dask worker with it, and its threads do not wait for each other.
"""

import io
import tempfile
import threading
import zipfile
from pathlib import Path
from typing import Final

from rig.sweeping.engine import PointReport, WorkerSetup
from rig.sweeping.errors import SweepStopped
from rig.sweeping.point import PointJob
from rig.sweeping.pool import Pool

_LOOK: Final = 3600.0
_OWN: Final = threading.local()


def pack(folder: Path) -> bytes:
    """Return the files of a folder as one, for another machine."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                archive.write(path, path.relative_to(folder))
    return packed.getvalue()


def run_here(job: PointJob, setup: WorkerSetup, configs: bytes) -> PointReport:
    """Run a point in this thread's own process.

    Parameters
    ----------
    job : PointJob
        As it stands on the machine of the sweep.
    setup : WorkerSetup
        What the process needs.
    configs : bytes
        The packed configurations.
    """
    own: _ThreadsOwn | None = _OWN.__dict__.get("own")
    if own is None or own.setup != setup:
        try:
            own = _OWN.own = _ThreadsOwn(setup)
        except SweepStopped as error:
            return PointReport(job.name, trouble=error.what)
    return own.run(job, configs)


class _ThreadsOwn:
    """The process of one thread, and a folder for it where it does not see the sweep's."""

    def __init__(self, setup: WorkerSetup) -> None:
        self.setup = setup
        self._pool = Pool(1, setup)
        self._place: tempfile.TemporaryDirectory[str] | None = None
        self._configs = b""

    def run(self, job: PointJob, configs: bytes) -> PointReport:
        """Run a point; without a file system that is shared its run folder is not kept."""
        shared = job.configs.is_dir()
        if not shared:
            place = self._unpacked(configs)
            job = job._replace(configs=place / "configs", logs=place / "runs")
        self._pool.submit(job)
        while not (reports := self._pool.wait(_LOOK)):
            continue
        return reports[0]

    def _unpacked(self, configs: bytes) -> Path:
        if self._place is None or configs != self._configs:
            self._place = tempfile.TemporaryDirectory(prefix="rig-sweep-")
            self._configs = configs
            with zipfile.ZipFile(io.BytesIO(configs)) as archive:
                archive.extractall(Path(self._place.name) / "configs")
        return Path(self._place.name)
