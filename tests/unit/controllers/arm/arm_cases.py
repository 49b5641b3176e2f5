"""Arms, joints and paths that several tests of the arm use."""

import math

import numpy as np

from controllers.arm.geometry import ArmGeometry
from controllers.arm.paths import Circle, Line


def radians(*degrees):
    return tuple(math.radians(angle) for angle in degrees)


START_FIG4 = radians(0, 30, 115, 30, -50, 0)

GEOMETRIES = {
    "paper": ArmGeometry(),
    "other wrist": ArmGeometry(wrist_sign=-1),
    "equal links": ArmGeometry(a2=0.4, a3=0.4),
    "offsets": ArmGeometry(
        a2=0.35, a3=0.3, elbow_offset=0.05, shoulder_offset=0.08, base_height=0.3, wrist_sign=-1
    ),
    "shoulder ahead": ArmGeometry(
        a1=0.09, a2=0.42, a3=0.36, d6=0.08, elbow_offset=-0.03, base_height=0.4
    ),
    "all offsets": ArmGeometry(
        a1=-0.05, a2=0.35, a3=0.3, elbow_offset=0.05, shoulder_offset=0.08, base_height=0.3
    ),
    "short forearm": ArmGeometry(a2=0.5, a3=0.2, d6=0.0, base_height=0.1),
}

SHOULDER_MISS = Line(
    middle=radians(0, 0, 115, 30, -50, 0),
    shoulder_distance=0.002,
    direction=(0.0, 1.0, 0.0),
    before=0.2,
    after=0.2,
)
SHOULDER_HIT = Line(
    middle=radians(0, 0, 115, 30, -50, 0), shoulder_distance=0.0, before=0.2, after=0.2
)
WRIST_MISS = Line(middle=radians(0, 20, 90, 90, 1, 0), direction=(0.0, 0.0, 1.0))
WRIST_HIT = Line(middle=radians(0, 20, 90, 0, 0, 0), direction=(0.0, 0.0, 1.0))
ELBOW_CIRCLE = Circle()
SHOULDER_CIRCLE = Circle("shoulder", (0.0, 0.0, 2.0, 0.5, -0.8, 0.0), radius=0.15, rate=0.6)


def random_joints(count, seed=1):
    """Return joints that are not at a singularity by chance."""
    rng = np.random.default_rng(seed)
    return [tuple(row) for row in rng.uniform(-2.8, 2.8, (count, 6)).tolist()]
