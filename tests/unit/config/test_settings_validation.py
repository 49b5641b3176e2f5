"""From a located mapping to a settings dataclass: the shapes that a field can have."""

from dataclasses import dataclass, field
from typing import Annotated, Literal

import pytest
from annotated_types import Ge, Interval, MinLen, Unit

from rig.config.diagnostics import Problems, ProfileError
from rig.config.located import Source
from rig.config.settings import build
from rig.config.yaml_loader import parse


@dataclass(frozen=True, slots=True)
class Inner:
    x: Annotated[float, Unit("m")] = 0.0
    y: float = 0.0


@dataclass(frozen=True, slots=True)
class Outer:
    number: Annotated[float, Unit("N"), Ge(0)] = 1.0
    whole: Annotated[int, Interval(ge=0, le=0xFFFF)] = 0
    rate: Annotated[int, Unit("bit/s")] = 0
    flag: bool = False
    text: Annotated[str, MinLen(1)] = "a"
    mode: Literal["on", "off", 3] = "on"
    optional: Annotated[float | None, Unit("s"), Ge(0)] = None
    either: float | str = 0.0
    pair: tuple[Annotated[float, Unit("m")], int] = (0.0, 0)
    many: Annotated[tuple[float, ...], Unit("m"), MinLen(1)] = (0.0,)
    by_name: dict[str, Inner] = field(default_factory=dict)
    lengths: Annotated[dict[str, float], Unit("m")] = field(default_factory=dict)
    nested: Inner = field(default_factory=lambda: Inner(1.0, 2.0))
    maybe: Inner | None = None
    inners: tuple[Inner, ...] = ()
    derived: float = field(init=False, default=5.0)


def make(text):
    problems = Problems()
    made = build(Outer, parse(Source("f", text), problems), problems)
    problems.raise_if_any()
    return made


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("number: 3", Outer(number=3.0)),
        ("number: 3 kN", Outer(number=3000.0)),
        ("whole: 0x1F", Outer(whole=31)),
        ("rate: 500 kbit/s", Outer(rate=500_000)),
        ("flag: true", Outer(flag=True)),
        ("mode: off", Outer(mode="off")),
        ("mode: 3", Outer(mode=3)),
        ("optional: 5 ms", Outer(optional=5e-3)),
        ("optional: null", Outer()),
        ("either: abc", Outer(either="abc")),
        ("pair: [1 mm, 2]", Outer(pair=(1e-3, 2))),
        ("many: [1 mm, 2, 3 cm]", Outer(many=(1e-3, 2.0, 3e-2))),
        ("by_name: {a: {x: 1 mm}, b: {}}", Outer(by_name={"a": Inner(1e-3), "b": Inner()})),
        ("lengths: {a: 1 mm}", Outer(lengths={"a": 1e-3})),
        ("maybe: {x: 2}", Outer(maybe=Inner(2.0))),
        ("nested: {}", Outer()),
        ("nested: {y: 3}", Outer(nested=Inner(1.0, 3.0))),
        ("inners: [{x: 2}, {}]", Outer(inners=(Inner(2.0), Inner()))),
    ],
)
def test_accepted(text, expected):
    made = make(text)
    assert made == expected
    assert type(made.number) is float


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("number: true", 1, 9, "number is true, expected a number in N"),
        ("number: -1 N", 1, 9, "number is '-1 N', expected at least 0 N"),
        ("number: 1e400", 1, 9, "expected a finite number"),
        ("whole: 1.0", 1, 8, "whole is 1, expected a whole number"),
        ("whole: '0x10'", 1, 8, "expected a whole number"),
        ("whole: 0x10000", 1, 8, "expected at most 65535"),
        ("whole: null", 1, 8, "whole is nothing, expected a whole number"),
        ("rate: 0.5 bit/s", 1, 7, "expected a whole number in bit/s"),
        ("text: ''", 1, 7, "at least 1 characters"),
        ("mode: ofF", 1, 7, "mode is 'ofF', expected 'on', 'off' or 3"),
        ("optional: -1", 1, 11, "expected at least 0 s"),
        ("pair: {a: 1}", 1, 7, "pair is a mapping, expected a list"),
        ("pair: [1 mm, 2.5]", 1, 14, "pair.1 is 2.5, expected a whole number"),
        ("pair: [1 mm]", 1, 7, "pair has 1 values, which is too few"),
        ("many: []", 1, 7, "at least 1 values"),
        ("many: 1, 2", 1, 7, "many is '1, 2', expected a list"),
        ("by_name:\n  a:\n    z: 1", 3, 5, "unknown key 'z'"),
        ("by_name: {a: {x: 1 s}}", 1, 18, "by_name.a.x: '1 s' is not in m"),
        ("lengths: {a: 1 s}", 1, 14, "lengths.a: '1 s' is not in m"),
        ("maybe: {x: 1 s}", 1, 12, "maybe.x: '1 s' is not in m"),
        ("inners: [{x: 1}, {x: z}]", 1, 22, "inners.1.x: 'z' does not start with a number"),
        ("nested: 3", 1, 9, "nested is 3, expected a mapping"),
        ("derived: 3", 1, 1, "unknown key 'derived'"),
    ],
)
def test_refused_at_its_place(text, line, column, message):
    with pytest.raises(ProfileError) as caught:
        make(text)
    (diagnostic,) = caught.value.diagnostics
    assert (diagnostic.mark.line, diagnostic.mark.column) == (line, column)
    assert message in diagnostic.message


def test_a_long_line_is_cut_around_the_caret():
    with pytest.raises(ProfileError) as caught:
        make("{text: a, " + " " * 300 + "number: -1, " + " " * 300 + "flag: true}")
    message, line, caret = str(caught.value).split("\n")
    assert "at least 0 N" in message
    assert len(line) <= 100
    assert line[caret.index("^") :].startswith("-1")


def test_a_thousand_errors_stay_readable():
    with pytest.raises(ProfileError) as caught:
        make("many: [" + ", ".join(["x"] * 1000) + "]")
    assert len(caught.value.diagnostics) == 1000
    assert str(caught.value).endswith("… and 900 more\n1000 errors")
