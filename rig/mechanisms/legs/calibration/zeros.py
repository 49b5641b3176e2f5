"""Zeros of the legs' joints, read in a jig that holds them at known angles.

The torque is off: nothing is driven against a stop, and what the encoders read is what the jig
makes of the joints, to its tolerance.
"""

import math
from collections.abc import Sequence

import numpy as np

from controllers.gait.geometry import AXIS_NAMES
from rig.calibration.arrays import Array
from rig.calibration.estimates import interval
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Finding, Panel
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.mechanisms.legs.calibration.jig import (
    JigProcedure,
    findings,
    jig_poses,
    measured,
    settings_of,
    steps_of,
)

_SAMPLES = 5
"""Of each stretch that are shown."""


class LegZeros(JigProcedure):
    """Procedure for the zero of every joint, in one pose."""

    name = "zeros"
    title = "zeros of the joints, in a jig"
    shares = ("scale",)
    pose_count = 1

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Compare what the encoders read with what the jig is made to."""
        poses = jig_poses(profile, self.pose_count)
        steps = steps_of(profile)
        (read,), (said,) = measured(poses, data, readings, steps)
        tolerance = profile.mechanism_settings.jig.tolerance
        values, estimates = [], []
        for k, (_, joint) in enumerate(settings_of(profile)):
            offset = float(joint.offset + said[k] - read[k])
            values.append({"offset": offset})
            # One angle cannot tell how well it repeats: the tolerances are taken at their word.
            std = math.hypot(tolerance, float(steps[k]) / math.sqrt(12.0))
            name = f"{AXIS_NAMES[k]}.offset"
            estimates.append((interval(name, offset, "rad", std, math.inf),))
        (name,) = poses
        stretch = data[name]
        samples = np.column_stack([stretch[f"reading.position_{j}"] for j in AXIS_NAMES])
        scatter = read - samples
        bound = 1e-3 + float(steps.max())
        return findings(profile, values, estimates, scatter, bound, (_panel(said, read, scatter),))


def _panel(said: Array, read: Array, scatter: Array) -> Panel:
    shown = scatter[:: max(len(scatter) // _SAMPLES, 1)][:_SAMPLES]
    joint = np.broadcast_to(np.arange(1.0, 13.0), shown.shape)
    fit = np.broadcast_to(1e3 * (said - read), shown.shape)
    return Panel(
        "zeros", "joint, right leg first", "jig less reading (mrad)", "scatter (mrad)",
        joint.ravel(), (fit + 1e3 * shown).ravel(), fit.ravel(), np.zeros(fit.size),
    )  # fmt: skip
