"""Axes that give way until their drives hold them: farther than a cycle may lead, or less."""

import pytest
from servo_fakes import NAMES, PERIOD, RATES, TINY, ServoBench

FAR = [rate * PERIOD for rate in RATES]
"""By so much each setpoint may differ from the one before, rad."""


def moved(bench, axis, way):
    bench.place(**{axis: way})
    return bench.axes.has_slipped(bench.axes.read(0.0))


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("axis", "far"), tuple(zip(NAMES, FAR, strict=True)))
def test_an_axis_has_slipped_that_is_farther_off_than_a_cycle_may_lead(axis, far, way):
    bench = ServoBench()
    bench.start()
    assert not moved(bench, axis, way * far)
    assert moved(bench, axis, way * (far + TINY))
    # Taken for where it is, it has not slipped.
    bench.start(**{axis: way * (far + TINY)})
    assert not moved(bench, axis, way * (far + TINY))


def test_what_slips_before_the_last_drive_holds_is_seen_in_the_cycle_in_which_it_does():
    bench = ServoBench()
    bench.start()
    bench.left.is_enabled = True
    assert moved(bench, "b", 1.0), "the other drive does not hold it yet"
    bench.right.is_enabled = True
    assert moved(bench, "b", 1.0), "they have begun with what they measure in this cycle"
    assert not moved(bench, "b", 1.0), "from now on it is a drive that does not follow"
    bench.right.is_enabled = False
    assert not moved(bench, "b", 1.0)
    assert moved(bench, "b", 1.0)


def test_before_the_first_cycle_nothing_has_slipped():
    assert moved(ServoBench(), "a", 1.0) is False
