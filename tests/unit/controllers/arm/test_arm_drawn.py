"""Drawn paths on drawn arms: a plan keeps what its law promises, or nothing is planned."""

import numpy as np
import pytest
from drawn_cases import draw_geometry, draw_offset_geometry, draw_path, faults_of
from refused_claims import Refused

from controllers.arm.esc import Esc, EscPaper, EscPaperSettings, EscSettings
from controllers.arm.look_ahead import LookAhead, LookAheadSettings
from controllers.arm.plain import (
    DampedLeastSquares,
    DampedSettings,
    Inverse,
    InverseSettings,
    ServoHalt,
    ServoHaltSettings,
)
from controllers.motion import InfeasibleMotion

PERIOD = 1e-2
ALL = range(6)
# Settings, and the joints whose rates and accelerations a law promises on every path.
LAWS = {
    "esc-paper": (EscPaper, EscPaperSettings(), (), ()),
    "esc": (Esc, EscSettings(), ALL, ()),
    "look-ahead": (LookAhead, LookAheadSettings(), ALL, ALL),
    # The rivals promise rates or nothing, and no path near a singularity.
    "inverse": (Inverse, InverseSettings(), (), ()),
    "dls": (DampedLeastSquares, DampedSettings(), ALL, ()),
    "servo-halt": (ServoHalt, ServoHaltSettings(), (), ()),
}
RIVALS = ("inverse", "dls", "servo-halt")
each_law = pytest.mark.parametrize("law", LAWS)


def judge(law, seeds, draw=draw_geometry):
    """Return what was planned, refused and wrong, by seed."""
    kind, settings, rates, accelerations = LAWS[law]
    planned, refused, wrong = [], [], {}

    def prepare(geometry, path):
        return kind(settings, geometry, PERIOD).prepare(path)

    def promised_by(path):
        turns = getattr(path, "turn_rate", 0.0) != 0.0
        return (2,) if law == "esc-paper" and not turns else rates

    for seed in seeds:
        rng = np.random.default_rng((2, seed))
        geometry = draw(rng)
        path = draw_path(rng, geometry)
        try:
            plan = prepare(geometry, path)
        except InfeasibleMotion as error:
            refused.append(seed)
            told = Refused(prepare, geometry, path, str(error), promised_by, accelerations)
            if false := told.false_claim():
                wrong[seed] = false
            continue
        planned.append(seed)
        promised = promised_by(path)
        keeps_path = law not in RIVALS
        faults = faults_of(geometry, path, plan, promised, accelerations, keeps_path=keeps_path)
        if faults:
            wrong[seed] = faults
    return planned, refused, wrong


@each_law
def test_a_few_drawn_paths(law):
    planned, refused, wrong = judge(law, range(8))
    assert not wrong
    assert planned
    assert refused or law in RIVALS  # they refuse less: they promise less


@pytest.mark.slow
@pytest.mark.sampled(1, each="law")
@each_law
@pytest.mark.parametrize("block", range(10))
def test_a_thousand_drawn_paths(law, block):
    planned, _, wrong = judge(law, range(1000 + 100 * block, 1100 + 100 * block))
    assert not wrong
    assert len(planned) > 20


@pytest.mark.slow
@each_law
def test_a_few_paths_of_offset_arms(law):
    planned, _, wrong = judge(law, range(12), draw_offset_geometry)
    assert not wrong
    assert planned


@pytest.mark.slow
@pytest.mark.sampled(1)
@each_law
@pytest.mark.parametrize("block", range(4))
def test_two_hundred_paths_of_offset_arms(law, block):
    seeds = range(2000 + 50 * block, 2050 + 50 * block)
    planned, _, wrong = judge(law, seeds, draw_offset_geometry)
    assert not wrong
    assert len(planned) > 10
