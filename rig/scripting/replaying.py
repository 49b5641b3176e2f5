"""`rig.replay`: a recorded run's log through the code at hand."""

import warnings
from pathlib import Path

from rig.config.setting import Setting
from rig.replaying.open_loop import OpenLoopAnswer, answer
from rig.replaying.recorded import open_recorded, other_version
from rig.replaying.verify import Verification, verify
from rig.scripting.recorded import Run
from rig.scripting.running import Settings, as_options


def replay(
    run: Run | str | Path,
    *,
    controller: str | None = None,
    set: Settings | None = None,
) -> Verification | OpenLoopAnswer:
    """Feed a run's readings to the controllers of the code at hand.

    Another version's recording is replayed with a warning that says so.

    Parameters
    ----------
    run : Run or Path
        A recorded run.
    controller : str, optional
        Another controller of its profile; what it would have commanded, in open loop.
    set : mapping, optional
        Other settings, likewise.

    Returns
    -------
    Verification or OpenLoopAnswer
        Whether every command is the log's, bit for bit; or what the other law would have
        commanded, which the rig did not follow.

    Raises
    ------
    ConfigurationError
        It cannot be replayed.
    LogError
        Its log is damaged.
    """
    path = run.path if isinstance(run, Run) else Path(run)
    options = as_options(set)
    if controller is not None:
        options.append(Setting(f"controller={controller}", f"controller={controller!r}"))
    recorded = open_recorded(path, options)
    versions = other_version(recorded.folder)
    if versions is not None:
        warnings.warn(f"{path}: {versions}", stacklevel=2)
    return answer(recorded) if options else verify(recorded)
