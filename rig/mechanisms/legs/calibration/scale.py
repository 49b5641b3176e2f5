"""Scale, direction and zero of the legs' encoders, from several poses of a jig.

Each joint's angle is a straight line through what its encoder read. An inclinometer on the links
may say the angles instead, in a file of readings.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from controllers.gait.geometry import AXIS_NAMES
from rig.calibration.arrays import Array
from rig.calibration.estimates import Estimate, interval
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Finding, Panel
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.legs.calibration.jig import (
    JigProcedure,
    findings,
    jig_poses,
    measured,
    settings_of,
    steps_of,
)

_LEAST_TURN = math.radians(10.0)
_WIDEST = 2.0
"""A scale further from 1 than this factor is a frozen or slipping encoder."""
_BOUND = 3.0
"""Residual above which a line is not to be used, in the stated uncertainty."""


class LegScale(JigProcedure):
    """Procedure for scale, direction and zero of every joint."""

    name = "scale"
    title = "scale, direction and zero of the joints' encoders, in several poses of a jig"

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit a line per joint."""
        poses = jig_poses(profile)
        steps = steps_of(profile)
        read, said = measured(poses, data, readings, steps)
        tolerance = profile.mechanism_settings.jig.tolerance
        values, estimates, fitted = [], [], np.empty_like(said)
        for k, (device, joint) in enumerate(settings_of(profile)):
            std = math.hypot(tolerance, float(steps[k]) / math.sqrt(12.0))
            nominal = profile.devices[device].nominal.joints[AXIS_NAMES[k]]
            value, found, line = _line(AXIS_NAMES[k], joint, nominal, read[:, k], said[:, k], std)
            values.append(value)
            estimates.append(found)
            fitted[:, k] = line
        residuals = said - fitted
        bound = _BOUND * math.hypot(tolerance, float(steps.max()))
        # Beside a joint that turns the other way nothing else would show.
        zeros = np.array([joint.offset for _, joint in settings_of(profile)])
        turns = np.sign(((read - read.mean(axis=0)) * (said - said.mean(axis=0))).sum(axis=0))
        panels = _panels(zeros + turns * (read - zeros), said, fitted)
        return findings(profile, values, estimates, residuals, bound, panels)


def _line(
    name: str, joint: Any, nominal: Any, read: Array, said: Array, std: float
) -> tuple[dict[str, Any], tuple[Estimate, ...], Array]:
    """Return settings, estimates and fitted angles of a joint."""
    turned, moved = float(np.ptp(said)), float(np.ptp(read))
    if turned < _LEAST_TURN:
        raise CalibrationRefused(
            f"{name}: the jig's poses turn it by {math.degrees(turned):.3g} deg, at least "
            f"{math.degrees(_LEAST_TURN):.3g} deg are needed"
        )
    if not 1.0 / _WIDEST < moved / turned < _WIDEST:
        raise CalibrationRefused(
            f"{name}: its encoder went through {math.degrees(moved):.3g} deg while the jig turned "
            f"it by {math.degrees(turned):.3g} deg: it is frozen, slips, or was not in the jig"
        )
    counted = read - joint.offset
    design = np.column_stack((counted, np.ones_like(counted)))
    gain, offset = np.linalg.lstsq(design, said, rcond=None)[0].tolist()
    covariance = np.linalg.inv(design.T @ design) * std**2
    scale = abs(gain) * nominal.gear / joint.gear
    spread = float(covariance[0, 0] ** 0.5) * nominal.gear / joint.gear
    value = {
        "gear": joint.gear / abs(gain),
        "offset": offset,
        "reversed": joint.reversed != (gain < 0.0),
    }
    # The jig's tolerance is known, and few poses say less of it: no interval from residuals.
    estimates = (
        interval(f"{name}.scale", scale, "1", spread, math.inf),
        interval(f"{name}.offset", offset, "rad", float(covariance[1, 1] ** 0.5), math.inf),
    )
    return value, estimates, design @ (gain, offset)


def _panels(read: Array, said: Array, fitted: Array) -> list[Panel]:
    """Return a panel per leg; `read` with the directions corrected."""
    panels = []
    for leg, mine in (("right leg", slice(0, 6)), ("left leg", slice(6, 12))):
        was = read[:, mine].ravel()
        angle, line = said[:, mine].ravel(), fitted[:, mine].ravel()
        panels.append(
            Panel(
                leg, "angle in the jig (deg)", "jig less reading (mrad)", "residual (mrad)",
                np.degrees(angle), 1e3 * (angle - was), 1e3 * (line - was), np.zeros(len(was)),
            )
        )  # fmt: skip
    return panels
