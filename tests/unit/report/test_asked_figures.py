"""Figures that a lab asks for: of a column, with nothing to draw, of a run over another one."""

import csv
import json

import numpy as np
import pytest

from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError
from rig.report.beside_figure import draw_beside
from rig.report.column_figure import draw_columns, file_of, is_column
from rig.report.data import load_run
from rig.report.figures import draw_figures
from rig.run_facts import EVALUATION


def ask_for(run, *figures):
    path = run / EVALUATION
    path.write_text(json.dumps({**json.loads(path.read_text()), "figures": figures}))


def table(path):
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array([[float(cell) for cell in row if cell] for row in rows])


def test_a_column_is_drawn_by_its_name_in_its_unit(make_run):
    run = make_run(duration=2.0)
    (picture, *_, numbers) = draw_figures(run, ["reading.pressure_agonist"]).files
    assert picture.name == "reading.pressure_agonist.png"
    header, rows = table(numbers)
    assert header[1].endswith("(kPa)")
    values = load_run(run).log.column("reading.pressure_agonist") * 1e-3
    assert (rows[:, 1].min(), rows[:, 1].max()) == pytest.approx((values.min(), values.max()))


def test_the_axis_of_a_column_says_the_quantity_and_its_unit(make_run):
    figure = draw_columns(load_run(make_run(duration=2.0)), "reading.pressure_agonist")
    assert [axes.get_ylabel() for axes in figure.axes] == ["pressure agonist\n(kPa)"]


def test_a_pattern_draws_each_column_in_a_panel(make_run):
    drawn = draw_figures(make_run(duration=2.0), ["reading.pressure_*"])
    header, _ = table(drawn.files[-1])
    assert drawn.files[0].name == "reading.pressure_all.png"
    assert [name.partition(" (")[0] for name in header[::2]] == ["panel 1", "panel 2"]
    assert "reading.pressure_antagonist" in header[2]


@pytest.mark.parametrize(
    "name", ["../../evil", "a/b.c", ".hidden", "a..b", "a.", "tracking", "a.b/c"]
)
def test_what_is_no_column_is_no_file(name):
    assert not is_column(name)


def test_a_file_has_no_characters_that_a_shell_would_take():
    assert is_column("device.oil_*") and file_of("device.oil_*") == "device.oil_all"


def test_a_column_that_no_run_of_the_rig_logs_is_refused_before_anything_moves():
    load_plan("cylinder-step", ["figures=[reading.pressure_*, truth.supply, timing.slack]"])
    with pytest.raises(ConfigurationError, match=r"no column 'reading\.presure_agonist'; did you"):
        load_plan("cylinder-step", ["figures=[reading.presure_agonist]"])


def test_one_line_says_what_has_nothing_to_draw(make_run, capsys):
    run = make_run(duration=2.0)
    ask_for(run, "tracking", "channels", "device.oil_value", "repeatability")
    content = json.loads((run / EVALUATION).read_text())
    (run / EVALUATION).write_text(json.dumps({**content, "mechanism": None}))
    assert invoke(["report", str(run), "--json"]) == 0
    told = capsys.readouterr()
    line = "nothing to draw: channels, device.oil_value, repeatability"
    assert told.err.strip() == line
    assert json.loads(told.out)["notes"] == [line]
    assert line in (run / "report.html").read_text()


def test_nothing_is_said_of_figures_that_nobody_asked_for(make_run, capsys):
    assert invoke(["report", str(make_run(duration=2.0))]) == 0
    assert capsys.readouterr().err == ""


def test_a_run_over_another_shows_what_is_between_them(make_run, capsys):
    run, other = make_run("one", error=1e-4), make_run("two", error=3e-4)
    assert invoke(["report", str(run), "--beside", str(other), "--json"]) == 0
    (residual,) = json.loads(capsys.readouterr().out)["residuals"]
    first, second = (load_run(path) for path in (run, other))
    apart = first.trace("reading.position") - second.trace("reading.position")
    assert residual["name"] == "reading.position"
    assert residual["rms"] == pytest.approx(np.sqrt(np.mean(apart**2)))
    assert residual["greatest"] == pytest.approx(np.abs(apart).max())
    assert residual["greatest"] > 2e-4
    header = (run / "figures" / "beside.csv").read_text().partition("\n")[0]
    assert "residual" in header
    assert 'alt="The run, another one' in (run / "report.html").read_text()


def test_the_same_run_is_nowhere_apart(make_run):
    run = make_run(duration=2.0)
    (residual,) = draw_beside(run, run).residuals
    assert residual.greatest == 0.0


def test_runs_without_a_common_stretch_are_refused(make_run):
    run, other = make_run("one", duration=2.0), make_run("two", duration=2.0)
    log = other / "log.mcap"
    log.write_bytes(log.read_bytes()[: len(log.read_bytes()) // 8])  # it ended in its approach
    with pytest.raises(ConfigurationError, match="nothing in common"):
        draw_beside(run, other)


def test_either_a_run_or_a_rehearsal(make_run, capsys):
    run = str(make_run(duration=2.0))
    assert invoke(["report", run, "--beside", run, "--rehearse"]) == 2
    assert "either" in capsys.readouterr().err
