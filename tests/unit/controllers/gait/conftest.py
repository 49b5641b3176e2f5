"""Plans of the base case, made once."""

import math
from functools import cache

import pytest
from gait_laws import LAWS

from controllers.gait.motions import BobSettings, SquatSettings, WalkSettings
from controllers.gait.types import GaitModel

MOTIONS = {
    "walk": WalkSettings(),
    "walk 5x": WalkSettings(speed=5.0),
    "walk touching": WalkSettings(knee_min=0.0),
    "walk with bob": WalkSettings(bob=BobSettings()),
    "squat": SquatSettings(),
}


@cache
def make_plan(law, motion, period):
    kind = {kind.name: kind for kind in LAWS}[law]
    return kind(kind.Settings(), GaitModel(), period).prepare(MOTIONS[motion])


@pytest.fixture(scope="session")
def plan():
    """Return ``plan(law, motion="walk", period=1e-3)``."""

    def get(law, motion="walk", period=1e-3):
        return make_plan(law, motion, period)

    return get


@pytest.fixture(scope="session")
def pulse():
    """Resolution of the servos, rad: 209 pulses per degree."""
    return math.radians(1.0 / 209.0)
