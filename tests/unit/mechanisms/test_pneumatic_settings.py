"""What a profile may say of pneumatic cylinders, and which devices can do it."""

from dataclasses import asdict

import pytest
from pneumatic_fakes import (
    HIGHEST,
    HOME,
    LOWEST,
    STROKE,
    TINY,
    FakeEncoder,
    FakeRegulators,
    pair_limits,
    pair_settings,
)

from rig.config.settings import adapter
from rig.hal import ConfigurationError
from rig.mechanisms.cylinder.settings import FrictionModel
from rig.mechanisms.pneumatic.devices import check_pneumatics

CHANNELS = ("one", "two")


def accept(channels=CHANNELS, pressure=(0.0, 500e3), regulates=(0.0, 500e3), encoders=None):
    check_pneumatics(
        "the test",
        channels,
        pressure,
        STROKE,
        FakeRegulators(CHANNELS, pressure_range=regulates),
        encoders or (FakeEncoder("first"), FakeEncoder("second")),
    )


def test_channels_must_be_the_mechanisms_in_their_order():
    accept()
    with pytest.raises(
        ConfigurationError, match="channels are one, two; the test needs two, one in this order"
    ):
        accept(channels=("two", "one"))


@pytest.mark.parametrize(
    ("pressure", "fits"),
    [
        ((96.0, 104.0), True),  # 100 … 180 Pa, and a twentieth of the 80 at either end
        ((96.0, 184.0), True),
        ((95.999, 184.0), False),
        ((96.0, 184.001), False),
    ],
)
def test_a_limit_may_exceed_what_regulators_set_by_a_twentieth(pressure, fits):
    if fits:
        accept(pressure=pressure, regulates=(100.0, 180.0))
        return
    with pytest.raises(ConfigurationError, match=r"exceeds what regulators can set, 96 … 184 Pa"):
        accept(pressure=pressure, regulates=(100.0, 180.0))


def test_an_encoder_measures_one_rod_over_the_whole_stroke():
    short = FakeEncoder("second", stroke=STROKE - TINY)
    with pytest.raises(ConfigurationError, match=r"second: its stroke .* is shorter"):
        accept(encoders=(FakeEncoder("first"), short))
    double = FakeEncoder("second")
    double.channels = ("a", "b")
    with pytest.raises(ConfigurationError, match="second: it has 2 channels, a rod needs one"):
        accept(encoders=(FakeEncoder("first"), double))


def test_friction_at_rest_is_at_least_that_of_sliding():
    FrictionModel(10.0, 10.0, 8e-3, 0.0)
    with pytest.raises(ValueError, match=r"breakaway \(9\.99 N\) is below coulomb \(10 N\)"):
        FrictionModel(10.0, 9.99, 8e-3, 0.0)


@pytest.mark.parametrize("name", ["position", "pressure"])
def test_a_range_has_its_lower_end_below_its_upper_one(name):
    """A profile is held to it with the type of the limits, so that it is told beside all else."""
    limits = pair_limits(**{name: (0.0, 1e-9)})
    adapter(type(limits)).validate_python(asdict(limits))
    for empty in ((0.0, 0.0), (1e-9, 0.0)):
        with pytest.raises(ValueError, match=rf"{name}: the lower limit"):
            adapter(type(limits)).validate_python(asdict(pair_limits(**{name: empty})))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rod": 16e-3}, "does not fit into bore"),
        ({"home": STROKE, "limits": pair_limits(position=(-1.0, 0.0))}, "is not within stroke"),
        ({"base_pressure": LOWEST - 1.0}, r"outside limits\.pressure 10000 … 500000 Pa"),
        ({"base_pressure": LOWEST}, r"is the least of limits\.pressure"),
        ({"base_pressure": HIGHEST + 1.0}, r"outside limits\.pressure 10000 … 500000 Pa"),
    ],
)
def test_a_cylinder_that_cannot_be_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        pair_settings(**changes)


def test_what_is_just_possible_is_accepted():
    pair_settings(rod=15e-3)  # a thicker one leaves too little area to pass limits.speed
    pair_settings(base_pressure=LOWEST + 1.0)
    pair_settings(base_pressure=HIGHEST)


@pytest.mark.parametrize("home", [0.25 * STROKE, HOME, 0.75 * STROKE])
def test_positions_must_be_within_what_the_stroke_leaves_around_home(home):
    reach = min(home, STROKE - home)
    for position in ((-reach, 0.0), (0.0, reach)):
        pair_settings(pair_limits(position=position), home=home)
    for position in ((-reach - TINY, 0.0), (0.0, reach + TINY)):
        with pytest.raises(ValueError, match="exceeds what the stroke leaves around home"):
            pair_settings(pair_limits(position=position), home=home)


def test_the_effective_area_is_the_ring_between_bore_and_rod():
    assert pair_settings().area == pytest.approx(181.427e-6, rel=1e-5)
