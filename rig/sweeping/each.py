"""A function of one's own for each of many cases, run as a sweep runs its points."""

import hashlib
import json
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from rig.sweeping.best import KEEP_ALL, Best
from rig.sweeping.code import code_version
from rig.sweeping.coordinator import Coordinator, Limits
from rig.sweeping.engine import WorkerSetup
from rig.sweeping.finding import PointFinding
from rig.sweeping.journal import Journal
from rig.sweeping.point import PointJob
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.sweeping.source import PointSource


def run_each(
    perform: str, cases: Sequence[tuple[str, ...]], folder: Path, workers: int
) -> list[PointFinding]:
    """Call a function for each case, in the processes of a pool; a finished case is not run again.

    Parameters
    ----------
    perform : str
        ``"module:function"``: takes a `PointJob`, whose options are the case, and returns what
        became of it. It may write below ``job.logs``.
    cases : sequence of tuple of str
        What differs from call to call.
    folder : Path
        Keeps what is finished.
    workers : int
        How many cases at once.

    Returns
    -------
    list of PointFinding
        In the order of the cases.

    Raises
    ------
    SweepStopped
        They cannot be run any more; what is finished is kept.
    """
    code = code_version().digest
    jobs = {case: _job(perform, case, code, folder.resolve()) for case in cases}
    setup = WorkerSetup(perform, code, folder.resolve() / "workers.log")
    with closing(Journal(folder)) as journal, closing(Pool(workers, setup)) as engine:
        progress = SweepProgress(len(jobs))
        best = Best(None, KEEP_ALL, folder)
        coordinator = Coordinator(journal, engine, progress, Limits(), best)
        coordinator.run(iter(jobs.values()))
        progress.clear()
        names = [jobs[case].name for case in cases]
        return [journal[name] if name in journal else coordinator.lost[name] for name in names]


def _job(perform: str, case: tuple[str, ...], code: str, folder: Path) -> PointJob:
    text = json.dumps([perform, case, code])
    name = hashlib.sha256(text.encode()).hexdigest()[:32]
    return PointJob(name, PointSource("", (), None, "", code), case, folder, folder / "runs" / name)
