"""Whether regulators and encoders can do what cylinders need, on the bounds."""

import math
from types import SimpleNamespace

import pytest

from rig.hal import ConfigurationError, SafetyError
from rig.mechanisms.pneumatic.devices import check_asked_pressures, check_pneumatics, settable

CHANNELS = ("ch1", "ch2")
LOW, HIGH = 4.0, 516.0
"""A range of 512: five hundredths of it are 25.6."""
STROKE = 2.0**-4


def regulators(low=LOW, high=HIGH, channels=CHANNELS):
    return SimpleNamespace(name="valves", channels=list(channels), pressure_range=(low, high))


def encoder(stroke=STROKE, channels=("rod",)):
    return SimpleNamespace(name="rod", channels=channels, stroke=stroke)


def check(pressure=(LOW, HIGH), encoders=(), **changes):
    made = regulators(**changes)
    check_pneumatics("the pair", CHANNELS, pressure, STROKE, made, encoders)


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ((0.0, 600.0), (LOW, HIGH)),
        ((LOW, HIGH), (LOW, HIGH)),
        ((8.0, 256.0), (8.0, 256.0)),
        ((0.0, 256.0), (LOW, 256.0)),
    ],
)
def test_what_may_be_set_is_what_both_permit(limits, expected):
    assert settable(limits, regulators()) == expected


def test_devices_that_fit_are_taken():
    check(encoders=(encoder(), encoder(2.0 * STROKE)))
    check(pressure=(5.0, 300.0))


@pytest.mark.parametrize("channels", [("ch2", "ch1"), ("ch1",), ("ch1", "ch2", "ch3")])
def test_other_channels_or_another_order_are_refused(channels):
    with pytest.raises(ConfigurationError) as caught:
        check(channels=channels)
    assert str(caught.value) == (
        f"valves: the channels are {', '.join(channels)}; the pair needs ch1, ch2 in this order"
    )


@pytest.mark.parametrize("end", [0, 1])
def test_limits_may_exceed_the_range_by_a_twentieth(end):
    bounds = (LOW - 0.05 * (HIGH - LOW), HIGH + 0.05 * (HIGH - LOW))
    check(pressure=bounds)
    beyond = list(bounds)
    beyond[end] = math.nextafter(bounds[end], (-math.inf, math.inf)[end])
    with pytest.raises(ConfigurationError) as caught:
        check(pressure=tuple(beyond))
    assert str(caught.value) == (
        "limits.pressure -21.6 … 541.6 Pa exceeds what valves can set, -21.6 … 541.6 Pa"
    )


@pytest.mark.parametrize(("channels", "count"), [((), 0), (("one", "two"), 2)])
def test_an_encoder_of_several_rods_or_of_none_is_refused(channels, count):
    with pytest.raises(ConfigurationError, match=f"^rod: it has {count} channels, a rod needs one"):
        check(encoders=(encoder(), encoder(channels=channels)))


def test_an_encoder_shorter_than_its_cylinder_is_refused():
    with pytest.raises(ConfigurationError, match=r"^rod: its stroke 0\.05 m is shorter than the "):
        check(encoders=(encoder(), encoder(0.05)))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_ten_times_the_greatest_pressure_may_be_asked_for_and_no_more(way):
    check_asked_pressures(CHANNELS, (0.0, way * 640.0), 64.0)
    with pytest.raises(SafetyError) as caught:
        check_asked_pressures(CHANNELS, (0.0, way * math.nextafter(640.0, 1e9)), 64.0)
    assert str(caught.value) == (
        f"the controller's command of ch2 is {way * 640:.4g} Pa, -640 … 640 Pa is allowed"
    )
