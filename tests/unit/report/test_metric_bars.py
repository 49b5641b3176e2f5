"""Bars of metrics: what has no length has a word, if it never came."""

from types import SimpleNamespace

import pytest

from rig.report.metric_bars import draw_metrics


@pytest.mark.parametrize(
    ("more", "said"),
    [({}, ["2", "never"]), ({"is_nan": True}, ["2"]), ({"bound": 1.0, "pass": None}, ["2"])],
)
def test_what_never_came_is_said_beside_no_bar(more, said):
    metrics = [{"name": "settling_time", "value": value, "unit": "s"} for value in (2.0, None)]
    metrics[1] |= more
    runs = [SimpleNamespace(metrics=(metric,)) for metric in metrics]
    axes = draw_metrics(runs, ["one", "other"]).axes[0]
    assert [text.get_text() for text in axes.texts] == said
