"""What validates a file says of anything what pydantic says of the annotation behind it."""

import random
from dataclasses import fields, is_dataclass
from typing import get_args

import pytest
from pydantic import ValidationError

from rig.assembly import REGISTRY
from rig.config.experiment import ExperimentHead
from rig.config.heads import ProfileHead
from rig.config.settings import adapter, validated
from rig.config.type_hints import hints, is_union, split_annotated

KINDS = ("mechanism", "driver", "bus", "plant", "controller", "reference")
ANYTHING = (
    None, True, 0, 1, -1, 2, 1.5, -0.5, 1e-9, 1e-30, 1e30, float("nan"), float("inf"), 10**30,
    "", "5 mm", "35 kPa", "-3 N", "1/s", "1e3 Hz", "20 deg", "5 parsec", "x", "standard",
    (), (0.0, 1.0), (1.0, 0.0), ("0 kPa", "5 kPa"), ("a",), {}, {"x": 1}, {"gain": "much"},
)  # fmt: skip
DOCUMENTS = 30


def document(hint, draw):
    """Draw something that a field may be given, a mapping where it is one, often."""
    bare, _ = split_annotated(hint)
    if is_union(bare):
        return document(draw.choice(get_args(bare)), draw)
    if not (isinstance(bare, type) and is_dataclass(bare)) or draw.random() < 0.05:
        return draw.choice(ANYTHING)
    keys = [field.name for field in fields(bare) if field.init and draw.random() < 0.6]
    found = {key: document(hints(bare)[key], draw) for key in keys}
    return found | ({"unknown": 1} if draw.random() < 0.1 else {})


def outcome(validate, hint, given):
    """Return what is made of it, or everything that is said against it."""
    try:
        return repr(validate(hint, given))  # two that are no numbers are not equal
    except ValidationError as error:
        return [
            (found["type"], found["loc"], found["msg"], repr(found.get("ctx")))
            for found in error.errors(include_url=False, include_input=False)
        ]


def every_settings():
    named = [
        (f"{kind} {name}", REGISTRY.settings(kind, name))
        for kind in KINDS
        for name in REGISTRY.imported(kind)
    ]
    return [("profile", ProfileHead), ("experiment", ExperimentHead), *named]


@pytest.mark.parametrize("settings", [pytest.param(s, id=name) for name, s in every_settings()])
def test_it_says_what_pydantic_says(settings):
    draw = random.Random(settings.__name__)
    said = 0
    for _ in range(DOCUMENTS):
        given = document(settings, draw)
        expected = outcome(lambda hint, data: adapter(hint).validate_python(data), settings, given)
        assert outcome(validated, settings, given) == expected, given
        said += isinstance(expected, list)
    assert said or not fields(settings)


def test_what_fits_is_made(settings=ProfileHead):
    valid = {"loop": {"rate": "500 Hz"}, "name": "x", "mechanism": "cylinder"}
    assert repr(validated(settings, valid)) == repr(adapter(settings).validate_python(valid))
