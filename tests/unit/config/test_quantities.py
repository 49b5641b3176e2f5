"""Quantities with units, exactly converted."""

import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.config.quantities import (
    UnitError,
    parse_any_quantity,
    parse_quantity,
    parse_unit,
    usual_units,
)
from rig.hal.formats import format_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("35 kPa", "Pa", 35e3), ("8.7 mm", "m", 8.7e-3), ("500 Hz", "Hz", 500.0),
        ("181.5 mm^2", "m^2", 181.5e-6), ("181.5 mm²", "m^2", 181.5e-6), ("2 mm/s", "m/s", 2e-3),
        ("0.5 MPa/s", "Pa/s", 5e5), ("1.5e5 N/m", "N/m", 1.5e5), ("25 N s/m", "N s/m", 25.0),
        ("25 N*s/m", "N s/m", 25.0), ("5 ms", "s", 5e-3), ("25 %", "1", 0.25), ("25%", "", 0.25),
        ("0.3 dm^3/(s bar)", "m^3/(s Pa)", 3e-9), ("20 degC", "K", 293.15), ("5µm", "m", 5e-6),
        ("5 μm", "m", 5e-6), ("1 1/s", "Hz", 1.0), ("3 m s^-2", "m/s^2", 3.0), ("1 L", "m^3", 1e-3),
        ("180 deg", "rad", math.pi), ("60 rpm", "rad/s", math.tau), ("1 N m", "J", 1.0),
        ("1 Mbit/s", "bit/s", 1e6), ("1e-999999999 m", "m", 0.0), ("0.5", "1", 0.5),
        ("3 m/s/s", "m/s^2", 3.0), ("1 bar", "Pa", 1e5), ("4.5 N/mm", "N/m", 4500.0),
    ],
)  # fmt: skip
def test_converts_to_the_nearest_float(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("35 mm", "Pa", r"'35 mm' is not in Pa; units that would do: Pa, kPa, MPa, bar, psi"),
        ("35", "Pa", "has no unit; wanted is a quantity in Pa, kPa"),
        ("10 Hz", "rad/s", "'10 Hz' is not in rad/s; units that would do: rad/s, deg/s, rpm"),
        ("3 furlong", "m", "'furlong' is not a unit"),
        ("kPa", "Pa", "does not start with a number"),
        ("1 N/m s", "N s/m", "ambiguous"),
        ("1e999 m", "m", "not a finite number"),
        ("1e300 km^9", "m^9", "not a finite number"),
        ("3 (((m", "m", "bracket is missing"),
        ("3 m)", "m", "bracket too many"),
        ("3 m^99", "m", "not a unit"),
        ("3 m2", "m^2", r"a power is written with \^"),
        ("3 m//s", "m/s", "a unit is missing"),
        ("3 m/", "m", "a unit is missing"),
        ("1 degC/s", "K/s", "use K"),
        ("nan m", "m", "does not start with a number"),
        ("1" * 100 + " m", "m", "too long"),
    ],
)
def test_says_what_would_do(text, unit, message):
    with pytest.raises(UnitError, match=message):
        parse_quantity(text, unit)


def test_any_unit_is_named_in_si():
    assert parse_any_quantity("0.15 mm") == (0.15e-3, "m")
    assert parse_any_quantity("3 cm^2") == (3e-4, "m^2")
    assert parse_any_quantity("25 %") == (0.25, "1")
    value, unit = parse_any_quantity("3 g m^2/s")
    assert value == 3e-3
    assert parse_unit(unit).dimension == parse_unit("kg m^2/s").dimension


def test_the_wanted_unit_comes_first():
    assert usual_units("Pa") == ("Pa", "kPa", "MPa", "bar", "psi")
    assert usual_units("m^3/(s Pa)") == ("m^3/(s Pa)", "dm^3/(s bar)")
    assert usual_units("kg/m") == ("kg/m",)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.12e-3, "m", "0.12 mm"), (3e-6, "m", "3 µm"), (1.5, "m", "1.5 m"), (0.0, "m", "0 mm"),
        (-3.5e-3, "m", "-3.5 mm"), (35e3, "Pa", "35 kPa"), (5e6, "Pa", "5 MPa"), (2e-3, "s",
         "2 ms"),
        (0.5, "", "0.5"), (0.5, "1", "0.5"), (math.pi / 9, "rad", "20 deg"), (1.0, "N", "1 N"),
        (40.0, "rad/s", "40 rad/s"), (2e-3, "m/s", "2 mm/s"), (1e-3, "m", "1 mm"),
    ],
)  # fmt: skip
def test_format_for_people(value, unit, text):
    assert format_quantity(value, unit) == text


@given(
    st.floats(min_value=-1e6, max_value=1e6, allow_subnormal=False),
    st.sampled_from(["m", "Pa", "s", "m/s", "rad", "N", "m^2", "bit/s", "m/s^2", "Hz"]),
)
def test_what_is_formatted_reads_back(value, unit):
    text = format_quantity(value, unit)
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-3, abs=1e-300)


@given(st.text(max_size=80))
def test_no_text_breaks_it(text):
    for unit in ("m", "1"):
        with suppress(UnitError):
            assert math.isfinite(parse_quantity(text, unit))
    with suppress(UnitError):
        parse_unit(text)
