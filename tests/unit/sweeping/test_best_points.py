"""The columns of a sweep that a terminal has room for: whole ones, with what was asked for."""

import random

import pytest

from rig.sweeping.best_points import fitting

HEADER = ("plant.friction", "simulation.seed", "status", *(f"metric_{k}" for k in range(9)))
ROWS = [("0.5", "1", "ok", *(f"{k}.25 mm" for k in range(9)))] * 3


def width(header, rows):
    return sum(max(map(len, column)) + 3 for column in zip(header, *rows, strict=True))


@pytest.mark.parametrize("seed", range(8))
def test_what_is_shown_fits_and_no_more_would(seed):
    chance = random.Random(seed)
    room, wanted = chance.randrange(60, 180), f"metric_{chance.randrange(9)}"
    header, rows = fitting(HEADER, ROWS, wanted, room)
    assert header[:3] == HEADER[:3] and wanted in header
    assert width(header, rows) <= room
    assert [HEADER.index(name) for name in header] == sorted(map(HEADER.index, header))
    assert rows == [tuple(row[HEADER.index(name)] for name in header) for row in ROWS]
    left = [name for name in HEADER if name not in header]
    if left:
        assert width(header, rows) + len(left[0]) + 3 > room


def test_settings_and_the_metric_stay_however_narrow_it_is():
    header, _ = fitting(HEADER, ROWS, "metric_7", 10)
    assert header == (*HEADER[:3], "metric_7")


def test_a_file_has_room_for_all():
    assert fitting(HEADER, ROWS, "metric_0", float("inf")) == (HEADER, ROWS)
