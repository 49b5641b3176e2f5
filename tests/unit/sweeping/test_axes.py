"""The axes of a sweep: what is written, what values come of it, and what is refused."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.hal import ConfigurationError
from rig.sweeping.axis import Axis, DrawnAxis, make_axis, parse_axis, parse_seeds
from rig.sweeping.design import MAX_POINTS, make_design
from rig.sweeping.stop_rule import parse_budget, parse_stop_rule
from rig.sweeping.table import value_of

NUMBERS = st.floats(-1e9, 1e9, allow_nan=False, allow_infinity=False)
UNITS = st.sampled_from(("", "mm", "kPa", "rad/s"))


def numbers(axis, unit=""):
    return [float(text.removesuffix(unit)) for text in axis.texts]


@given(NUMBERS, NUMBERS, st.integers(2, 200), UNITS)
def test_a_grid_has_its_ends_and_is_even(low, high, count, unit):
    axis = make_axis("a.b", f"{low!r}..{high!r} {unit}:{count}")
    found = numbers(axis, unit)
    size = max(abs(low), abs(high))
    assert axis.setting == "a.b"
    assert found[0] == pytest.approx(low, rel=1e-11, abs=1e-11 * size)
    assert found[-1] == pytest.approx(high, rel=1e-11, abs=1e-11 * size)
    assert found == sorted(found, reverse=high < low)
    if abs(high - low) > 1e-6 * size:
        assert len(found) == count
        step = (high - low) / (count - 1)
        assert all(b - a == pytest.approx(step, abs=1e-10 * size) for a, b in pairwise(found))


def test_a_grid_is_written_as_a_person_would():
    assert make_axis("a", "0..1:11").texts[3] == "0.3"
    assert make_axis("a", "1 mm..5 mm:3").texts == ("1 mm", "3 mm", "5 mm")
    assert make_axis("a", "1..5:5").texts == ("1", "2", "3", "4", "5")
    assert make_axis("a", "7..9:1").texts == ("7",)


@given(st.floats(1e-9, 1e9), st.floats(1.1, 1e6), st.integers(2, 50))
def test_a_logarithmic_grid_grows_by_one_factor(low, ratio, count):
    found = numbers(make_axis("a", f"log:{low!r}..{low * ratio!r}:{count}"))
    step = ratio ** (1 / (count - 1))
    assert found[0] == pytest.approx(low) and found[-1] == pytest.approx(low * ratio)
    for before, after in pairwise(found):
        assert after / before == pytest.approx(step, rel=1e-8)


@given(st.lists(st.text("abcxyz-_0123456789", min_size=1, max_size=8), min_size=1, max_size=9))
def test_a_list_keeps_its_order_and_has_each_value_once(values):
    assert make_axis("a", ",".join(values)).texts == tuple(dict.fromkeys(values))


def test_a_list_is_split_outside_of_brackets_and_quotes():
    axis = parse_axis("a.b = [1, 2],{x: 3, y: 4},'p,q'")
    assert axis == Axis("a.b", ("[1, 2]", "{x: 3, y: 4}", "'p,q'"))


@pytest.mark.parametrize(
    "text",
    ["", "a", "a=", "=1", "a=1..5", "a=1..5:0", "a=1..5:x", "a=log:0..1:3", "a=log:-1..1:3",
     "a=1,,2", "a=uniform:1:3", "a=1 mm..5 kPa:3", "a=1..5:1000000000", "a=normal:1:3"],
)  # fmt: skip
def test_what_is_no_axis_is_refused_with_a_sentence(text):
    with pytest.raises(ConfigurationError, match="--vary"):
        parse_axis(text)


@settings(max_examples=200)
@given(st.text(max_size=40))
def test_any_text_is_an_axis_or_refused(text):
    try:
        axis = parse_axis(text)
    except ConfigurationError:
        return
    assert axis.setting and (isinstance(axis, DrawnAxis) or all(axis.texts))


def test_seeds():
    assert parse_seeds("3:6").texts == ("3", "4", "5")
    assert parse_seeds("7, 1").texts == ("7", "1")
    for text in ("5:5", "6:3", "a", "1:2:3", "-1:4", "0:1000000000"):
        with pytest.raises(ConfigurationError, match="--seeds"):
            parse_seeds(text)


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4), st.integers(0, 4))
def test_every_combination_is_one_point(sizes, seeds):
    axes = [Axis(f"a{k}", tuple(f"{k}{i}" for i in range(size))) for k, size in enumerate(sizes)]
    design = make_design(axes, parse_seeds(f"0:{seeds}") if seeds else None)
    points = [design.texts(number) for number in range(design.count)]
    assert len(points) == math.prod(sizes) * max(seeds, 1)
    assert len(set(points)) == len(points)
    assert points == sorted(points, key=lambda texts: [
        (axis.texts.index(text)) for axis, text in zip(design.axes, texts, strict=True)
    ])  # fmt: skip


@pytest.mark.parametrize("kind", ["uniform:2..3", "sobol:2..3", "normal:2+-0.1"])
def test_more_draws_leave_the_first_as_they_are(kind):
    few, more = (
        make_design([make_axis("a.b", f"{kind}:{count}")]).axes[0].texts for count in (9, 40)
    )
    assert more[:9] == few and len(set(more)) == 40
    assert make_design([make_axis("a.b", f"{kind}:9")], draw_seed=1).axes[0].texts != few


def test_draws_lie_where_they_should():
    axes = [make_axis("a", "uniform:2..3:2000"), make_axis("b", "normal:5+-0.5 mm:2000"),
            make_axis("c", "sobol:0..1:2000"), make_axis("d", "sobol:0..1:2000")]  # fmt: skip
    design = make_design(axes)
    a, b, c, d = (
        numbers(axis, unit) for axis, unit in zip(design.axes, ["", "mm", "", ""], strict=True)
    )
    assert design.count == 2000
    assert 2.0 <= min(a) < 2.01 and 2.99 < max(a) <= 3.0
    assert sum(b) / 2000 == pytest.approx(5.0, abs=0.05)
    assert (sum((x - 5.0) ** 2 for x in b) / 2000) ** 0.5 == pytest.approx(0.5, rel=0.06)
    quarter = sum(x < 0.5 and y < 0.5 for x, y in zip(c, d, strict=True))
    assert quarter == pytest.approx(500, abs=5)  # chance alone would be 19 off


def test_axes_that_are_drawn_have_as_many_values():
    with pytest.raises(ConfigurationError, match="as many values"):
        make_design([make_axis("a", "uniform:0..1:5"), make_axis("b", "sobol:0..1:6")])


def test_what_is_varied_twice_or_too_often_is_refused():
    with pytest.raises(ConfigurationError, match="varied twice"):
        make_design([make_axis("a", "1,2"), make_axis("a", "3,4")])
    with pytest.raises(ConfigurationError, match="--seeds varies it"):
        make_design([make_axis("simulation.seed", "1,2")], parse_seeds("0:2"))
    axis = make_axis("a", "0..1:100000")
    assert make_design([axis], parse_seeds("0:10")).count == MAX_POINTS
    with pytest.raises(ConfigurationError, match="1,000,000,000 points"):
        make_design([axis], parse_seeds("0:10000"))


@given(NUMBERS)
def test_a_value_in_the_table_is_si(x):
    assert value_of(f"{x!r} kPa") == pytest.approx(1e3 * x, rel=1e-12)
    assert value_of(repr(x)) == x


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("-3", -3), ("1e-3", 1e-3), ("true", "true"), ("cascade", "cascade"),
     ("nan", "nan"), ("1_000", "1_000"), ("9" * 30, 1e30), ("20 deg", math.radians(20))],
)  # fmt: skip
def test_a_value_in_the_table_is_a_number_or_its_text(text, value):
    assert value_of(text) == value and type(value_of(text)) is type(value)


@pytest.mark.parametrize(
    ("rule", "value", "unit", "holds"),
    [("rms < 0.2 mm", 1.9e-4, "m", True), ("rms < 0.2 mm", 2.1e-4, "m", False),
     ("rms<=1", 1.0, "", True), ("rms > 3", 4.0, "m", True), ("rms >= 3", 2.0, "m", False),
     ("other < 1", 0.0, "m", False), ("rms < 1", math.nan, "m", False)],
)  # fmt: skip
def test_when_a_sweep_may_end(rule, value, unit, holds):
    metric = {"name": "rms", "value": value, "unit": unit, "bound": None, "kind": None}
    finding = {"point": "", "status": "ok", "reason": "", "metrics": [metric]}
    assert parse_stop_rule(rule).reached(finding) is holds


def test_a_bound_of_another_unit_is_refused():
    metric = {"name": "rms", "value": 1.0, "unit": "Pa", "bound": None, "kind": None}
    finding = {"point": "", "status": "ok", "reason": "", "metrics": [metric]}
    with pytest.raises(ConfigurationError, match="in m, the metric in Pa"):
        parse_stop_rule("rms < 1 mm").reached(finding)


@pytest.mark.parametrize("text", ["rms", "rms < x", "< 3", "rms = 3", "rms < 1 furlong"])
def test_what_is_no_rule_is_refused(text):
    with pytest.raises(ConfigurationError, match="stop when"):
        parse_stop_rule(text)


def test_a_budget_is_a_time_or_a_number_of_points():
    assert parse_budget("30 min") == (1800.0, None)
    assert parse_budget("500 points") == (None, 500.0)
    for text in ("5 mm", "soon", "-3 s"):
        with pytest.raises(ConfigurationError, match="budget"):
            parse_budget(text)


@pytest.mark.parametrize("values", ["1,2,3 mm", "1 mm,2", "1e-3, 2 mm"])
def test_a_list_where_some_have_a_unit_and_some_have_none_is_refused(values):
    with pytest.raises(ConfigurationError, match="in a list each value has its own"):
        make_axis("reference.size", values)


@pytest.mark.parametrize("values", ["1,2,3", "1e-3,2E-3", "1 mm,2 mm", "cascade,pid", "5,off"])
def test_a_list_of_one_kind_is_taken(values):
    assert make_axis("a", values).texts == tuple(values.split(","))


@pytest.mark.parametrize(
    "values",
    [
        "1..1e999999999:3", "1..1e999:3", f"1..{'9' * 400}:3", "-1e160..1:3", f"1..5:{'9' * 5000}",
        "uniform:-1e308..1e308:5", "normal:0+-1e300:5", "log:1e-300..1:5",
    ],
)  # fmt: skip
def test_a_range_beyond_all_numbers_is_refused_at_once(values):
    with pytest.raises(ConfigurationError, match="range"):
        make_axis("a", values)


@pytest.mark.parametrize("seeds", ["9" * 5000, f"0:{'9' * 5000}", f"1,{'9' * 5000}"])
def test_a_seed_of_five_thousand_digits_is_refused(seeds):
    with pytest.raises(ConfigurationError, match="seeds"):
        parse_seeds(seeds)
