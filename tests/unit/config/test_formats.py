"""Numbers as people read them."""

import math

import pytest

from rig.hal.formats import format_against, format_outside, format_to


@pytest.mark.parametrize(
    ("value", "bound", "unit", "texts"),
    [
        (10.8583, 10.8603, "s", ("10.858 s", "10.86 s")),
        (10.8583, 10.8603, "", ("10.858", "10.86")),
        (5.4289, 5.4309, "s", ("5.429 s", "5.431 s")),
        (0.9986, 1.0, "rad/s", ("0.9986 rad/s", "1 rad/s")),
        (0.99999, 1.0, "rad/s", ("0.99999 rad/s", "1 rad/s")),
        (12e-6, 0.11e-3, "m", ("0.012 mm", "0.11 mm")),
        (0.0, 5e3, "Pa", ("0 kPa", "5 kPa")),
        (1.0, 1.0, "1", ("1", "1")),
        (1.0, 0.0, "", ("1", "0")),
        (2e-3, None, "m", ("2 mm", "")),
        (None, 0.5, "s", ("never", "0.5 s")),
        (math.inf, None, "s", ("never", "")),
        (math.nan, None, "s", ("NaN", "")),
        (math.nan, 2e-3, "m", ("NaN", "2 mm")),
    ],
)
def test_a_number_and_its_bound_are_told_apart(value, bound, unit, texts):
    assert format_against(value, bound, unit) == texts


@pytest.mark.parametrize(
    ("values", "unit", "text"),
    [
        ((-0.000554465, -5e-4, 5e-4), "m", "-0.5545 mm, outside -0.5 … 0.5 mm"),
        ((300000.1, 0.0, 3e5), "Pa", "300.0001 kPa, outside 0 … 300 kPa"),
        ((0.2, 0.0, 0.1), "rad", "11.46 deg, outside 0 … 5.73 deg"),
        ((math.nan, 0.0, 3e5), "Pa", "nan kPa, outside 0 … 300 kPa"),
        ((4e-3, -math.inf, 3e-3), "m", "4 mm, outside -inf … 3 mm"),
        ((2e-3, -math.inf, math.inf), "m", "2 mm, outside -inf … inf mm"),
        ((2.0, 1.0, 1.0), "", "2, outside 1 … 1"),
        ((1.0, 1.0, 1.0), "1", "1, outside 1 … 1"),
    ],
)
def test_what_has_left_its_range_is_told_in_one_unit(values, unit, text):
    assert format_outside(*values, unit) == text


@pytest.mark.parametrize(
    ("value", "std", "unit", "texts"),
    [
        (29.994e-3, 2.1e-6, "m", ("29.9940 mm", "29.9919 mm", "29.9961 mm")),
        (60011.4, 8.1, "N/m", ("60011.4 N/m", "60003.3 N/m", "60019.5 N/m")),
        (60011.4, 8100.0, "N/m", ("60011 N/m", "51911 N/m", "68111 N/m")),
        (1.234e-12, 5e-15, "m^3/(s Pa)",
         ("1.2340e-12 m^3/(s Pa)", "1.2290e-12 m^3/(s Pa)", "1.2390e-12 m^3/(s Pa)")),
        (0.1946, 0.0003, "1", ("0.19460", "0.19430", "0.19490")),
        (0.0, 0.25, "1", ("0.00", "-0.25", "0.25")),
        (2.0, 0.0, "s", ("2 s", "2 s", "2 s")),
    ],
)  # fmt: skip
def test_a_measured_number_is_told_to_two_digits_of_its_deviation(value, std, unit, texts):
    assert tuple(format_to(value, std, unit, (value - std, value + std))) == texts
