"""The loop of one pair of the joint, measured: from a run of the reference ``joint-probe``.

The law of a pair sees its two rods and the force to which the four tensions amount, and sends such
a force; so does this. The pair is the one that the motion moves more.
"""

from typing import TYPE_CHECKING

import numpy as np

from controllers.spherical_joint.pose_control import PoseController
from rig.assembly import REGISTRY
from rig.config import load_experiment, load_profile
from rig.hal import ConfigurationError
from rig.hal.measured_loop import Array, MeasuredLoop
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.references.probe import JointProbe
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.joint.shaken_ring import shaken_signals
from rig.mechanisms.pneumatic.shaken_run import loop_of_glides, whole_glides

if TYPE_CHECKING:
    from rig.report.data import RunData


def loop_of_run(run: "RunData", law: object) -> MeasuredLoop:
    """Return the loop that a law closes around a pair in a run.

    Parameters
    ----------
    run : RunData
        Of the reference ``joint-probe``.
    law : object
        Made for that rig; it is not changed, and need not be the one that ran.

    Raises
    ------
    ConfigurationError
        The run or the law does not tell it.
    """
    path = run.folder.path
    probe = load_experiment(path / "experiment.yaml", REGISTRY).reference.settings
    if not isinstance(probe, JointProbe):
        raise ConfigurationError(f"{path}: its reference is no joint-probe")
    if not isinstance(law, PoseController):
        raise ConfigurationError(f"what is linear of {type(law).__name__} is not known")
    settings = load_profile(path / "profile.yaml", REGISTRY).mechanism_settings
    assert isinstance(settings, JointSettings)
    axis = np.column_stack([run.trace(f"estimate.encoder_marker_{name}") for name in "xyz"])
    signals = shaken_signals(
        settings.geometry,
        axis,
        *(_columns(run, kind) for kind in ("reading.rod_", "applied.", "reading.pressure_")),
    )
    glides = whole_glides(run, signals)
    return loop_of_glides(run, probe.frequencies, glides, law.pair_law, "the ring")


def _columns(run: "RunData", kind: str) -> Array:
    return np.column_stack([run.trace(f"{kind}{channel}") for channel in CHANNELS])
