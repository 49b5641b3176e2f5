"""Variations by name: what they change, their table with its worst, and the names of faults."""

import csv
import json
import math
import random

import numpy as np
import pytest

from rig.hal import ConfigurationError, DeviceFault, LimitExceeded
from rig.report.style import paper_style, save
from rig.sweeping.axis import parse_axis, parse_seeds
from rig.sweeping.data import SweepData
from rig.sweeping.design import make_design
from rig.sweeping.figure import draw_sweep
from rig.sweeping.sweep_file import load_sweep, variations_of
from rig.sweeping.table import TableRow, value_of
from rig.sweeping.variation_table import fault_name, table_of, write_variations

NAMED = {
    "friction x 0.6": {"plant.friction_scale": 0.6},
    "slow": {"plant.regulator.bandwidth": "20 rad/s", "plant.regulator.dead_time": "7 ms"},
}
LAWS = ("pid", "cascade")


def data_of(outcome, seeds="0:3", sense="max", metrics=("rms",)):
    """Make a sweep; `outcome` gives a value (m) or the reason why there is none."""
    axes = [parse_axis(f"controller={','.join(LAWS)}"), variations_of(NAMED)]
    design = make_design(axes, parse_seeds(seeds))
    rows = []
    for number in range(design.count):
        texts = design.texts(number)
        found = outcome(*texts)
        told = {"value": found, "unit": "m", "bound": 1.0, "kind": sense}
        cells = [{"name": name, **told} for name in metrics]
        stopped = isinstance(found, str)
        finding = {
            "point": f"{number:032x}", "status": "faulted" if stopped else "ok",
            "reason": found if stopped else "", "metrics": [] if stopped else cells,
        }  # fmt: skip
        rows.append(TableRow(tuple(map(value_of, texts)), finding))
    return SweepData.of([axis.setting for axis in design.axes], rows)


def test_each_variation_changes_all_that_it_names_and_the_nominal_one_nothing():
    design = make_design([parse_axis("controller=pid"), variations_of(NAMED)])
    assert [design.options(k) for k in range(3)] == [
        ("controller=pid",),
        ("controller=pid", "plant.friction_scale=0.6"),
        ("controller=pid", "plant.regulator.bandwidth=20 rad/s", "plant.regulator.dead_time=7 ms"),
    ]
    assert design.options(2)[1].written == "variations: slow: plant.regulator.bandwidth: 20 rad/s"


@pytest.mark.parametrize("sense", ["max", "min"])
@pytest.mark.parametrize("number", range(5))
def test_a_cell_is_the_worst_of_its_seeds_and_the_last_row_the_worst_of_all(number, sense):
    chance = random.Random(number)
    drawn = {}

    def outcome(law, variation, seed):
        drawn[law, variation, seed] = chance.uniform(1e-4, 5e-3)
        return drawn[law, variation, seed]

    table = table_of(data_of(outcome, sense=sense), "rms")
    worst = max if sense == "max" else min
    assert table.laws == LAWS and list(table.rows) == ["nominal", *NAMED]
    for variation, cells in table.rows.items():
        for law, cell in zip(LAWS, cells, strict=True):
            assert cell.value == worst(drawn[law, variation, str(seed)] for seed in range(3))
    for law, cell in zip(LAWS, table.worst, strict=True):
        assert cell.value == worst(value for key, value in drawn.items() if key[0] == law)
    assert [row[0] for row in table.texts()] == ["nominal", *NAMED, "worst"]


REASON = "the pair oscillates at 4.4 Hz, 21 mm peak to peak, about its reference: the gains …"


def test_what_stopped_is_a_cell_with_its_name_and_counts_among_the_worst(tmp_path):
    def outcome(law, variation, seed):
        if law == "pid" and variation == "slow":
            return REASON if seed != "0" else 9e-3
        return 1e-3

    data = data_of(outcome)
    table = table_of(data, "rms")
    pid, cascade = table.rows["slow"]
    assert pid == (9e-3, (REASON, REASON), 0) and cascade == (1e-3, (), 0)
    assert table.texts()[-1] == ("worst", "2 stopped, 9 mm", "1 mm")
    assert table.texts()[2] == ("slow", "the pair oscillates (2 runs)", "1 mm")
    assert table.faults() == {"the pair oscillates": REASON}
    write_variations(tmp_path, data)
    rows = list(csv.DictReader((tmp_path / "variations.csv").read_text().splitlines()))
    assert rows[2] == {
        "metric": "rms", "variation": "slow", "pid": "the pair oscillates (2 runs)",
        "cascade": "1 mm",
    }  # fmt: skip
    (kept,) = json.loads((tmp_path / "variations.json").read_text())
    assert kept["rows"]["slow"][0] == {"value": 9e-3, "stopped": [REASON, REASON], "missed": 0}


def test_a_law_that_misses_a_bound_has_it_beside_its_figures_and_hollow_marks():
    data = data_of(lambda law, variation, seed: 1e-3 if law == "pid" else 2e-3)
    for k, law in enumerate(data.settings["controller"]):
        if law == "pid" and data.settings["variation"][k] == "slow":
            data.statuses[k], data.reasons[k] = "failed", "missed settling"
    table = table_of(data, "rms")
    assert table.texts()[2:] == [
        ("slow", "1 mm, bound missed", "2 mm"), ("worst", "1 mm, bound missed", "2 mm")
    ]  # fmt: skip
    assert table.texts()[0] == ("nominal", "1 mm", "2 mm")
    axes = draw_sweep(data).axes[0]
    assert axes.get_title(loc="right") == "hollow: bound missed"
    (hollow,) = [line for line in axes.get_lines() if line.get_markerfacecolor() == "white"]
    assert list(hollow.get_xdata()) == pytest.approx([1.0, 1.0])


def test_nothing_but_stops_is_a_table_too_and_a_point_that_is_not_finished_a_dash():
    data = data_of(lambda law, variation, seed: 1e-3 if law == "cascade" else "gone")
    table = table_of(data, "rms")
    assert np.isnan(table.worst[0].value) and len(table.worst[0].stopped) == 9
    assert table.texts()[0][1] == "gone (3 runs)"
    for column in (*data.settings.values(), data.points, data.statuses, data.reasons):
        del column[9:]
    del data.metrics["rms"].numbers[9:]
    data.settings["controller"][0] = "cascade"
    assert table_of(data, "rms").rows["slow"][0].text("m") == "-"


@pytest.mark.parametrize(
    ("reason", "name"),
    [
        (REASON, "the pair oscillates"),
        (str(LimitExceeded("following error of the pair for 0.3 s", 4e-3, -3e-3, 3e-3, "m")),
         "following error of the pair"),
        (str(DeviceFault("regulators", "channel agonist does not follow", node=16, value="3 V")),
         "channel agonist does not follow"),
        ("regulators: ch1 is stuck closed, or its chamber leaks", "ch1 is stuck closed"),
        ("3.5", "3.5"),
    ],
)  # fmt: skip
def test_a_fault_is_named_by_its_words(reason, name):
    if name == "ch1 is stuck closed":  # a channel's number is part of no name
        name = "ch"
    assert fault_name(reason) == name


def test_every_variation_is_a_row_of_the_figure_and_each_law_a_mark_in_it():
    values = {"nominal": 1e-3, "friction x 0.6": 2e-3, "slow": 8e-3}

    def outcome(law, variation, seed):
        return REASON if (law, variation) == ("pid", "slow") else values[variation] * len(law)

    figure = draw_sweep(data_of(outcome))
    (axes,) = figure.axes
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == ["nominal", *NAMED, "worst"]
    marks = {line.get_label(): line.get_xdata() for line in axes.get_lines()}
    assert np.allclose(marks["cascade"], [7.0, 14.0, 56.0, 56.0])  # mm
    assert np.allclose(marks["pid"][:2], [3.0, 6.0]) and np.isnan(marks["pid"][2])
    crosses = [line for line in axes.get_lines() if line.get_marker() == "x"]
    assert [len(line.get_ydata()) for line in crosses] == [2]  # slow, and the worst
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(LAWS)


def test_the_names_of_rows_are_on_the_figure_where_nothing_was_stopped(tmp_path):
    def outcome(law, variation, seed):
        return 1e-3 * (1 + len(variation))

    with paper_style():
        figure = draw_sweep(data_of(outcome, metrics=("rms", "hold_rms", "wire_rms")))
        save(figure, tmp_path, "sweep", "an origin")
    page = figure.bbox
    for label in figure.axes[0].get_yticklabels():
        place = label.get_window_extent()
        assert page.x0 <= place.x0 and place.x1 <= page.x1, label.get_text()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{nominal: {a.b: 1}}", "no name of a variation"),
        ("{worst: {a.b: 1}}", "no name of a variation"),
        ("{2 ms: {a.b: 1}}", "begins with a letter"),
        ("{slow: 3}", "slow: expected settings"),
        ("{slow: {}}", "slow: it changes nothing"),
        ("{}", "0 variations"),
        ("[slow]", "expected settings"),
    ],
)
def test_what_is_no_variation_is_refused_with_its_name(tmp_path, text, said):
    file = tmp_path / "sweep.yaml"
    file.write_text(f"experiment: cylinder-sine\nvariations: {text}\n")
    with pytest.raises(ConfigurationError, match=said):
        load_sweep(file)


def test_what_a_variation_changes_nothing_else_varies():
    for axes, seeds in (([parse_axis("plant.friction_scale=1,2")], None), ([], "0:2")):
        named = {"other": {"plant.friction_scale": 0.5, "simulation.seed": 7}}
        with pytest.raises(ConfigurationError, match="varied twice"):
            make_design([*axes, variations_of(named)], seeds and parse_seeds(seeds))


def test_what_never_came_is_a_word_in_the_table_and_no_mark_in_the_figure(tmp_path):
    data = data_of(lambda law, *rest: math.inf if law == "pid" else 1e-3)
    table = table_of(data, "rms")
    assert {row[1:] for row in table.texts()} == {("never", "1 mm")}
    write_variations(tmp_path, data)
    (told,) = json.loads((tmp_path / "variations.json").read_text())
    assert all(cells[0]["value"] is None for cells in told["rows"].values())
    with paper_style():
        save(draw_sweep(data), tmp_path, "sweep", "an origin")
