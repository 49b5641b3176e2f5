"""The figure of a sweep shows its numbers, in the form that suits what was varied."""

import math
from array import array

import numpy as np
import pytest

from rig.hal import ConfigurationError
from rig.sweeping.axis import parse_axis, parse_seeds
from rig.sweeping.best import Best
from rig.sweeping.best_points import best_points
from rig.sweeping.data import MetricColumn, SweepData
from rig.sweeping.design import make_design
from rig.sweeping.figure import draw_sweep
from rig.sweeping.table import TableRow, value_of


def data_of(axes, seeds, rms):
    """Make a sweep; `rms` (m) is a function of a point's values, None where it fails."""
    design = make_design([parse_axis(axis) for axis in axes], parse_seeds(seeds))
    rows = []
    for number in range(design.count):
        values = tuple(map(value_of, design.texts(number)))
        value = rms(*values)
        metrics = [{"name": "rms", "value": value, "unit": "m", "bound": 1.0, "kind": "max"}]
        status, metrics = ("faulted", []) if value is None else ("ok", metrics)
        finding = {"point": f"{number:032x}", "status": status, "reason": "", "metrics": metrics}
        rows.append(TableRow(values, finding))
    return SweepData.of([axis.setting for axis in design.axes], rows)


def line(axes, label):
    return next(found for found in axes.get_lines() if found.get_label() == label).get_data()


def test_one_number_is_a_curve_of_medians_with_the_worst_beside():
    data = data_of(["a.b=1..4:4"], "0:5", lambda x, seed: 1e-3 * (x + seed) if x < 4 else None)
    axes = draw_sweep(data).axes[0]
    x, median = line(axes, "median")
    assert np.allclose(median[:3], x[:3] + 2.0) and np.isnan(median[3])  # mm
    assert np.allclose(line(axes, "worst")[1][:3], x[:3] + 4.0)
    assert list(line(axes, "failed")[0]) == [4.0] * 5
    assert axes.get_xlabel() == "a.b" and axes.get_ylabel() == "rms (mm)"


def test_names_are_groups():
    data = data_of(["law=pid,cascade"], "0:3", lambda law, seed: 1e-3 * (len(law) + seed))
    axes = draw_sweep(data).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["pid", "cascade"]
    middles = [found.get_ydata()[0] for found in axes.get_lines() if found.get_marker() == "o"]
    assert middles == pytest.approx([4.0, 8.0])


def test_two_settings_are_a_map_of_the_median_and_of_the_worst():
    axes = ["a.b=1..3:3", "c=10,20"]
    data = data_of(axes, "0:3", lambda x, y, seed: 1e-3 * (x * y + seed) if x * y < 60 else None)
    figure = draw_sweep(data)
    median, worst = (np.ma.filled(panel.images[0].get_array(), np.nan) for panel in figure.axes[:2])
    expected = np.array([[10, 20, 30], [20, 40, np.nan]])
    assert np.allclose(median, expected + 1.0, equal_nan=True)
    assert np.allclose(worst, expected + 2.0, equal_nan=True)


def test_more_settings_are_parallel_coordinates_with_the_worst_on_top():
    axes = ["a=sobol:0..1:16", "b=sobol:0..1:16", "c=sobol:5..6:16"]
    data = data_of(axes, "0:1", lambda a, b, c, seed: 1e-3 * (a + b))
    axes = draw_sweep(data).axes[0]
    lines = axes.collections[0]
    assert len(lines.get_segments()) == 16
    assert list(lines.get_array()) == sorted(lines.get_array())
    ends = [segment[-1][1] for segment in lines.get_segments()]
    assert ends == sorted(ends) and ends[0] == 0.0 and ends[-1] == 1.0


def test_a_metric_that_is_better_when_greater_has_its_worst_below():
    data = data_of(["a=1,2"], "0:3", lambda x, seed: 1e-3 * (x + seed))
    data.metrics["rms"].kind = "min"
    assert np.allclose(line(draw_sweep(data).axes[0], "worst")[1], [1.0, 2.0])
    assert data.points[data.order()[0]] == f"{5:032x}"


def test_without_any_result_there_is_no_figure():
    with pytest.raises(ConfigurationError, match="no point ran to its end"):
        draw_sweep(data_of(["a=1,2"], "0:1", lambda x, seed: None))


def with_metric(axes, name, unit, value, bound=None, seeds="0:2"):
    """Make a sweep with another metric, `value` of a point's values."""
    data = data_of(axes, seeds, lambda *values: 1e-3)
    numbers = array("d", (value(*point) for point in zip(*data.settings.values(), strict=True)))
    data.metrics = {name: MetricColumn(unit, bound, "max", numbers)}
    return data


@pytest.mark.parametrize("axes_of", [["a=1,2"], ["a=x,y"], ["a=1,2", "b=1,2"]])
def test_what_never_came_is_said(axes_of):
    figure = draw_sweep(with_metric(axes_of, "settling_time", "s", lambda *_: math.inf, 1.0))
    texts = [*figure.texts, *(text for axes in figure.axes for text in axes.texts)]
    assert [text.get_text().rpartition(" ")[2] for text in texts] == ["never"]
    assert not any(len(axes.get_yticks()) for axes in figure.axes)
    for axes in figure.axes:
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["bound 1 s"]
        assert axes.get_xlim()[1] > 1.0
    figure = draw_sweep(with_metric(axes_of, "settling_time", "s", lambda *_: math.inf))
    assert not any(axes.get_legend() for axes in figure.axes)


def test_many_settings_without_any_number_are_said():
    axes = ["a=sobol:0..1:4", "b=sobol:0..1:4", "c=sobol:5..6:4"]
    figure = draw_sweep(with_metric(axes, "settling_time", "s", lambda *_: math.inf))
    assert [text.get_text() for text in figure.texts] == ["settling time: never"]
    figure = draw_sweep(with_metric(axes, "settling_time", "s", lambda *_: math.nan))
    assert [text.get_text() for text in figure.texts] == ["settling time: no number"]


def test_where_it_never_came_there_is_a_mark():
    data = with_metric(["a=1,2,3"], "time", "s", lambda a, seed: math.inf if a == 2 else 1.0 * a)
    axes = draw_sweep(data).axes[0]
    assert list(line(axes, "never")[0]) == [2.0, 2.0]
    assert not axes.texts


@pytest.mark.parametrize(
    ("unit", "value", "bound", "shown", "label"),
    [
        ("m^3/s", 1e-3 / 60, None, 1.0, "air (NL/min)"),
        ("Pa", 2e6, None, 2.0, "air (MPa)"),
        ("Pa", 5e3, 1.5e6, 5.0, "air (kPa)"),
        ("m", 2e-3, None, 2.0, "air (mm)"),
        ("rad", math.pi, None, 180.0, "air (deg)"),
        ("", 0.3, None, 0.3, "air"),
        ("s", 0.0, 1.0, 0.0, "air (s)"),
    ],
)
def test_units_are_those_of_the_table(unit, value, bound, shown, label):
    axes = draw_sweep(with_metric(["a=1,2"], "air", unit, lambda *_: value, bound)).axes[0]
    assert axes.get_ylabel() == label
    assert line(axes, "median")[1] == pytest.approx([shown, shown])


def test_a_bound_that_is_far_off_has_its_unit():
    data = with_metric(["a=1,2"], "low", "Pa", lambda a, seed: 5e4 + a, bound=15e3)
    labels = [found.get_label() for found in draw_sweep(data).axes[0].get_lines()]
    assert "bound 15 kPa" in labels


def test_metrics_that_have_no_room_are_named():
    data = data_of(["a=1,2"], "0:2", lambda a, seed: 1e-3)
    (column,) = data.metrics.values()
    data.metrics = {f"metric_{k}": column for k in range(8)}
    figure = draw_sweep(data)
    assert figure.get_suptitle() == "not drawn: metric 6, metric 7"
    del data.metrics["metric_6"], data.metrics["metric_7"]
    assert not draw_sweep(data).get_suptitle()


def missing(axes, seeds="0:2"):
    """Make a sweep whose smallest numbers are those of points that missed a bound."""
    data = data_of(axes, seeds, lambda *values: 1e-3 * (1.0 + values[0]))
    for k, value in enumerate(data.settings["a"]):
        if value == 1:
            data.statuses[k], data.reasons[k] = "failed", "missed settling"
    return data


def test_what_missed_a_bound_is_best_of_nothing_and_says_so():
    data = missing(["a=1,2"])
    assert [data.settings["a"][k] for k in data.order()] == [2, 2, 1, 1]
    header, rows = best_points(data, None)
    ends = [row[header.index("status")] for row in rows]
    assert ends == ["ok", "ok", "bound missed", "bound missed"]
    data.reasons[data.order()[-1]] = "the pair hunts"
    assert best_points(data, None)[1][-1][header.index("status")] == "flawed"


@pytest.mark.parametrize(
    ("axes_of", "said"),
    [
        (["a=1,2"], "bound missed"),
        (["a=1,2", "b=1,2"], "ringed: a bound was missed"),
        (["a=1,2", "b=1,2", "c=1,2"], "dashed: a bound was missed"),
    ],
)
def test_what_missed_a_bound_is_marked(axes_of, said):
    figure = draw_sweep(missing(axes_of))
    texts = [text.get_text() for text in figure.texts]
    suptitle = figure.get_suptitle()
    for axes in figure.axes:
        legend = axes.get_legend()
        texts += [axes.get_title(loc="right")]
        texts += [] if legend is None else [text.get_text() for text in legend.get_texts()]
    assert said in [*texts, suptitle]


def test_run_folders_are_kept_of_points_that_kept_their_bounds(tmp_path):
    best = Best("rms", 1, tmp_path)
    for name, status, value in (("x", "failed", 1.0), ("y", "ok", 3.0), ("z", "ok", 2.0)):
        (tmp_path / name).mkdir()
        cell = {"name": "rms", "value": value, "unit": "m", "bound": 1.0, "kind": "max"}
        best.take({"point": name, "status": status, "reason": "", "metrics": [cell]})
    assert [folder.name for folder in tmp_path.iterdir()] == ["z"]
