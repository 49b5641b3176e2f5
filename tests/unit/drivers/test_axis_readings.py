"""What the readings of joints with a drive each say as one."""

from types import SimpleNamespace

import pytest

from drivers.servos.axis_readings import AxisReadings


@pytest.mark.parametrize(
    ("times", "oldest"),
    [((1.0, 0.5, 0.7), "b"), ((0.5, 0.5, 0.7), ""), ((2.0, 2.0, 2.0), ""), ((0.1, 3.0, 2.0), "a")],
)
def test_the_oldest_joint_is_the_one_that_is_alone_with_its_time(times, oldest):
    drives = [SimpleNamespace(time=t, position=0.0) for t in times]
    told = SimpleNamespace(axis_names=("a", "b", "c"), drives=drives)
    assert AxisReadings.oldest_axis.fget(told) == oldest
