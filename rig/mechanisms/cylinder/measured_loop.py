"""The loop of a pair, measured: from a run of the reference ``probe``.

One run tells the loop of the law that ran, and of the same law with other gains: see
`rig.mechanisms.pneumatic.shaken_pair`.
"""

from typing import TYPE_CHECKING, Final

import numpy as np

from controllers.cylinder.law import PairLaw
from rig.assembly import REGISTRY
from rig.config import load_experiment
from rig.hal import ConfigurationError
from rig.hal.measured_loop import MeasuredLoop
from rig.mechanisms.cylinder.probe import Probe
from rig.mechanisms.pneumatic.shaken_run import loop_of_glides, whole_glides

if TYPE_CHECKING:
    from rig.report.data import RunData

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
    sent, pressed = (run.trace(a) - run.trace(b) for a, b in _SIGNALS.values())
    signals = np.column_stack([sent, run.trace("reading.position"), pressed])
    return loop_of_glides(run, settings.frequencies, whole_glides(run, signals), law, "the pair")
