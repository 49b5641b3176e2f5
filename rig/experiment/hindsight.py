"""What is said of a rig once a fault has ended its run."""

from pathlib import Path
from typing import Any

from rig.hal import Mechanism
from rig.runtime.log import LogError, read_log

Said = tuple[str, str, dict[str, Any]]
"""Kind of an event, its sentence and its data."""


def after_fault(
    mechanism: Mechanism[Any, Any, Any, Any], fault: Exception, log_path: Path
) -> list[Said]:
    """Return how the rig is held, and what explains the end of its log best.

    Parameters
    ----------
    mechanism : Mechanism
        Of the rig, which was made safe.
    fault : Exception
        What ended the run.
    log_path : Path
        Of its log, which is closed.
    """
    held = mechanism.pose_held()
    said: list[Said] = [] if held is None else [("hold", held, {})]
    try:
        suspects = mechanism.diagnose(fault, read_log(log_path).column)
    except LogError:  # the fault may be that nothing can be recorded
        return said
    if suspects:
        sentence = "; or, as well: ".join(suspect.sentence for suspect in suspects)
        causes = [suspect._asdict() for suspect in suspects]
        said.append(("diagnosis", f"the last second fits best: {sentence}", {"causes": causes}))
    return said
