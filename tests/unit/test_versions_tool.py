"""What `tests/versions` calls the same: bytes of one resolution, else numbers but for rounding."""

import json
import random
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "versions"))

from comparison import same_bytes, same_numbers
from interpreters import find_interpreters


def texts(value, unit="m"):
    return {"sine": json.dumps({"metrics": [{"name": "rms", "value": value, "unit": unit}]})}


@pytest.mark.parametrize("seed", range(5))
def test_the_last_digit_is_other_bytes_and_the_same_number(seed):
    value = random.Random(seed).uniform(1e-3, 1.0)
    near, far = texts(value * (1 + 4e-16)), texts(value * (1 + 1e-9))
    assert not list(same_bytes(texts(value), texts(value)))
    assert list(same_bytes(texts(value), near)) == ["sine"]
    assert not list(same_numbers(texts(value), near))
    assert len(list(same_numbers(texts(value), far))) == 1


@pytest.mark.parametrize("other", [{}, texts(1.0, "rad"), texts(None)])
def test_what_is_missing_or_of_another_unit_differs(other):
    assert list(same_bytes(texts(1.0), other))
    assert list(same_numbers(texts(1.0), other))


def test_the_interpreter_that_runs_this_or_one_like_it_is_found():
    assert f"{sys.version_info.major}.{sys.version_info.minor}" in find_interpreters()
