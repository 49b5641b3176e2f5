"""When a fault stopped a run, by both of its clocks, and in which stretch of the motion."""

from pathlib import Path

from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.hal import ConfigurationError
from rig.run_facts import EVALUATION, LOG, read_events
from rig.run_folder import RunFolder, RunFolderError
from rig.runtime.log import LogError, read_log
from rig.runtime.phases import Phase


def fault_time(folder: Path) -> str | None:
    """Return when a run's fault was, each time with its clock; None: there was none in its loop.

    What a damaged folder does not tell is left out.
    """
    times = [event.get("t") for event in read_events(folder) if event.get("kind") == "fault"]
    if not times or times[-1] is None:
        return None
    said = f"{times[-1]:.3f} s after the run began (the log's clock)"
    try:
        log = read_log(folder / LOG)
        phases, reference = log.column("phase"), log.column("reference.time")
        reached = reference[phases == Phase.RUN]
        if not len(reached):
            return f"{said}, before its motion"
        t = float(reached[-1])
        content = RunFolder.open(folder).read_json(EVALUATION, Evaluation)
        segments, _ = evaluation_from_json(content)
    except (ConfigurationError, LogError, RunFolderError, OSError):
        return said
    where = ", ".join(repr(name) for name, start, end in segments if start <= t < end)
    stretch = f", in {where}" if where else ""
    return f"{said}, {t:.3f} s of the reference{stretch}"
