"""What is said of a rig once its run has ended and it was made safe."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from rig.assembly import Rig
from rig.runtime.log import LogError
from rig.runtime.log_columns import read_columns

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Said = tuple[str, str, dict[str, object]]
"""Kind of an event, its sentence and its data."""


def after_run(rig: Rig, fault: Exception | None, log_path: Path) -> list[Said]:
    """Return how the rig is held, what explains a fault best, and what else its log tells.

    Parameters
    ----------
    rig : Rig
        Which was made safe.
    fault : Exception or None
        What ended the run early.
    log_path : Path
        Of its log, which is closed.
    """
    mechanism = rig.mechanism
    said: list[Said] = []
    if fault is not None and (held := mechanism.pose_held()):
        said.append(("hold", held, {}))
    log = cache(lambda: read_columns(log_path))  # read only if somebody asks

    def logged(name: str) -> "NDArray[np.float64]":
        return log().column(name)

    try:
        suspects = () if fault is None else mechanism.diagnose(fault, logged)
        if suspects:
            sentence = "; or, as well: ".join(suspect.sentence for suspect in suspects)
            causes = [suspect._asdict() for suspect in suspects]
            said.append(("diagnosis", f"the last second fits best: {sentence}", {"causes": causes}))
        said += [(kind, message, {}) for kind, message in mechanism.remarks(logged)]
    except LogError:
        pass  # what ended the run may be that nothing can be recorded
    except Exception as error:  # nothing that is found afterwards may hide how the run has ended
        said.append(("diagnosis", f"the log could not be looked back at: {error!r}", {}))
    return said
