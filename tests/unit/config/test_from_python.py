"""Settings that Python made: taken as a file would give them, or refused in its words."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from controllers.arm.online.commands import ArmTwists, TwistRows
from controllers.arm.paths import TurnBack
from rig.config import ProfileError
from rig.config.from_python import as_from_a_file
from rig.mechanisms.cylinder.references import Sine, SineTone

WHOLE = (0, 0, 1, 0, 1, 0)
FLOATS = (0.0, 0.0, 1.0, 0.0, 1.0, 0.0)


class Sticks(ArmTwists):
    """Holds more than its settings, as a script's own class may."""

    def twist(self, t):
        return self.told


def sticks(start):
    made = Sticks(start=start)
    object.__setattr__(made, "told", "kept")
    return made


@pytest.mark.parametrize(
    "start", [WHOLE, list(WHOLE), np.array(WHOLE), np.float32(WHOLE), ("0 deg", *FLOATS[1:])]
)
def test_numbers_of_any_kind_become_floats(start):
    made = sticks(start)
    as_from_a_file(made, "it")
    assert made.start == FLOATS and [type(q) for q in made.start] == [float] * 6
    assert made.twist(0.0) == "kept"


@pytest.mark.parametrize(
    ("start", "said"),
    [
        (FLOATS[:5], "it: start has 5 values, which is too few"),
        ((math.nan, *FLOATS[1:]), "it: start.0 is nan, expected a finite number"),
        (("0 mm", *FLOATS[1:]), "it: start.0: '0 mm' is not in rad"),
        ((object(), *FLOATS[1:]), "it: start.0 is .*expected a number in rad"),
    ],
)
def test_what_a_file_could_not_say_is_refused(start, said):
    with pytest.raises(ProfileError, match=said):
        as_from_a_file(sticks(start), "it")


def test_bounds_hold_and_what_nests_is_reached():
    with pytest.raises(ProfileError, match=r"it: silence is 0.5, expected at most 0.1 s"):
        as_from_a_file(Sticks(silence=0.5), "it")
    sine = Sine(1, (SineTone(2, 3),))
    as_from_a_file(sine, "it")
    assert type(sine.amplitude) is type(sine.tones[0].frequency) is float
    rows = TwistRows(start=WHOLE, rows=[(0, 0, 0, 1, 0, 0, 0), (1, 0, 0, 0, 0, 0, 0)])
    as_from_a_file(rows, "it")
    assert {type(value) for row in rows.rows for value in row} == {float}
    back = TurnBack(start=WHOLE, direction=(1, 0, 1))
    as_from_a_file(back, "it")
    assert {type(value) for value in (*back.start, *back.direction)} == {float}


def test_what_is_no_settings_stays_as_it_is():
    @dataclass(frozen=True)
    class Own(Sticks):
        more: "Unheard" = object  # noqa: F821

    own, other = Own(start=WHOLE), [1]
    as_from_a_file(own, "it")
    as_from_a_file(other, "it")
    assert own.start == FLOATS and own.more is object and other == [1]
