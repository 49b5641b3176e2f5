"""Pose controllers with what they would measure of a joint that follows its reference."""

import math
from dataclasses import replace

import pytest

from controllers.spherical_joint.dither import DitherSettings
from controllers.spherical_joint.laws import (
    JointCascade,
    JointPid,
    JointPidFriction,
    JointSuperTwisting,
)
from controllers.spherical_joint.poses import natural_rotation
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.types import JointModel, JointReference
from controllers.spherical_joint.wires import InverseKinematics

PERIOD = 1e-3
MODEL = JointModel()
BASE = (MODEL.base_pressure,) * 4
ALL = [JointPid, JointPidFriction, JointCascade, JointSuperTwisting]
ZERO = (0.0, 0.0, 0.0)

every = pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.__name__)


def build(kind, model=MODEL, **changes):
    """Return a controller without dither, if the changes say nothing else."""
    settings = replace(kind.Settings(), **{"dither": DitherSettings(), **changes})
    if kind is JointPidFriction:
        settings = replace(settings, pair=replace(settings.pair, dither_amplitude=0.0))
    return kind(settings, model, PERIOD)


def circle(t, tilt=20.0, rate=2.0):
    lean, turn = math.radians(tilt), rate * t
    x, y = math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn)
    return JointReference(
        (x, y, math.cos(lean)),
        (-rate * y, rate * x, 0.0),
        (-rate * rate * x, -rate * rate * y, 0.0),
    )


def resting(axis):
    return JointReference(axis, ZERO, ZERO)


def rods_at(axis, pressures=BASE, model=MODEL):
    """Return the rods' positions of a ring at rest: wires stretch under the pressures' pull."""
    stretch = model.area / model.wire_stiffness
    return tuple(
        position + stretch * pressure
        for position, pressure in zip(
            InverseKinematics(model.geometry).shortening(axis), pressures, strict=True
        )
    )


def pressures_at(axis):
    """Return the pressures that hold a pose without friction, with every wire taut."""
    tensions = TensionDistribution(MODEL.geometry).hold(
        natural_rotation(axis), 10.0, 4.0 * MODEL.area * MODEL.base_pressure
    )
    return tuple(tension / MODEL.area for tension in tensions)
