"""Events of a run, as it writes them while it moves."""

import contextlib
from typing import Any

from rig.hal import RigError
from rig.run_folder import RunFolder


class Events:
    """Writes events; a full disk must not keep the rig from being made safe."""

    def __init__(self, folder: RunFolder) -> None:
        self._folder = folder

    def __call__(self, t: float | None, kind: str, message: str, data: dict[str, Any]) -> None:
        """Write one, at a time of the log (s), or before and after it (None)."""
        with contextlib.suppress(RigError):
            self._folder.record_event(t, kind, message, **data)
