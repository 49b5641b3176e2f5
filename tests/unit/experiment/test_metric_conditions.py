"""A metric that is asked for with some settings only."""

from pathlib import Path

import pytest

from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError

CONFIGS = Path(__file__).parents[3] / "configs"
WHEN = "metrics={stroke: {measure: path_deviation, max: 1 mm, when: {WHEN}}, time_end: {}}"


def metrics(when, *options):
    text = WHEN.replace("WHEN", when)
    return set(load_plan("arm-wrist-hit", [text, *options], configs=CONFIGS).experiment.metrics)


@pytest.mark.parametrize(
    ("when", "asked"),
    [
        ("", True),
        ("arm.geometry.wrist_sign: 1", True),
        ("arm.geometry.wrist_sign: -1", False),
        ("controller: esc, loop.rate: 200", True),
        ("controller: dls, loop.rate: 200", False),
    ],
)
def test_metric_is_left_out_unless_all_settings_are_as_it_says(when, asked):
    assert metrics(when) == ({"stroke", "time_end"} if asked else {"time_end"})


def test_options_count():
    assert "stroke" in metrics("arm.geometry.wrist_sign: -1", "arm.geometry.wrist_sign=-1")


def test_setting_that_is_not_there_is_named():
    with pytest.raises(ConfigurationError, match=r"metric stroke: .*'wrist_sing'; there is a2, "):
        metrics("arm.geometry.wrist_sing: 1")
