"""The loop of a pair, measured: from a run of the reference ``probe``.

One run tells the loop of the law that ran, and of the same law with other gains: see
`rig.mechanisms.pneumatic.shaken_pair`.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np

from controllers.cylinder.law import PairLaw
from rig.assembly import REGISTRY
from rig.config import load_experiment
from rig.hal import ConfigurationError
from rig.hal.measured_loop import Array, MeasuredLoop
from rig.mechanisms.cylinder.probe import Probe
from rig.mechanisms.pneumatic.shaken_pair import ShakenLaw, ShakenPair

if TYPE_CHECKING:
    from rig.report.data import RunData

_ROUNDING: Final = 1e-6
"""s, of the times of cycles."""
_SIGNALS: Final = {
    "sent": ("applied.agonist", "applied.antagonist"),
    "pressed": ("reading.pressure_agonist", "reading.pressure_antagonist"),
}


def loop_of_run(run: "RunData", law: object) -> MeasuredLoop:
    """Return the loop that a law closes around the pair of a run.

    Parameters
    ----------
    run : RunData
        Of the reference ``probe``.
    law : object
        Made for that rig; it is not changed, and need not be the one that ran.

    Raises
    ------
    ConfigurationError
        The run or the law does not tell it.
    """
    settings = load_experiment(run.folder.path / "experiment.yaml", REGISTRY).reference.settings
    if not isinstance(settings, Probe):
        raise ConfigurationError(f"{run.folder.path}: its reference is no probe")
    if not isinstance(law, PairLaw):
        raise ConfigurationError(f"what is linear of {type(law).__name__} is not known")
    try:
        pair = ShakenPair(settings.frequencies, _glides(run))
    except ValueError as error:
        raise ConfigurationError(f"{run.folder.path}: {error}") from error
    try:
        return pair.under(ShakenLaw(law, settings.frequencies))
    except ValueError as error:
        raise ConfigurationError(
            f"{error}: the pair sticks, or swings by itself, while it glides"
        ) from error


def _glides(run: "RunData") -> Iterator[tuple[Array, Array]]:
    """Yield times, and what was sent and read, of each whole glide of a run."""
    t = run.time
    sent, pressed = (run.trace(a) - run.trace(b) for a, b in _SIGNALS.values())
    signals = np.column_stack([sent, run.trace("reading.position"), pressed])
    for segment in run.segments:
        if t[-1] >= segment.end:
            part = (t >= segment.start - _ROUNDING) & (t < segment.end - _ROUNDING)
            yield t[part] - segment.start, signals[part]
