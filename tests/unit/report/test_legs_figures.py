"""What the legs' figures show of a walk and of a knee bend, and of walks side by side."""

from pathlib import Path

import numpy as np
import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.mechanisms.legs.comparison import LEGS_COMPARISON
from rig.mechanisms.legs.figures.gait import LEGS_FIGURES
from rig.report.comparison import metric_values
from rig.report.comparisons import comparison_of
from rig.report.data import load_run
from rig.report.style import paper_style

CONFIGS = Path(__file__).parents[3] / "configs"
BRISK = ["reference.landings=2", "reference.speed=6", "approach=0.3 s"]
BEND = ["reference.repeats=1", "reference.speed=4", "approach=0.3 s", "metrics={fell: {}}"]
METRICS = "metrics={peak_knee_rate: {}, leg_mismatch: {}, fell: {segments: all}}"


@pytest.fixture(scope="module")
def run_of(tmp_path_factory):
    """Return ``run_of(experiment, options)``: a run, made once."""
    made = {}

    def get(name, *options):
        if (name, options) not in made:
            plan = load_plan(name, list(options), configs=CONFIGS)
            out = tmp_path_factory.mktemp("runs")
            made[name, options] = run_experiment(plan, Backend.SIM, out, report=False).path
        return load_run(made[name, options])

    return get


def drawn(name, run):
    with paper_style():
        return LEGS_FIGURES[name].draw(run)


def test_knees_are_drawn_over_the_phases(run_of):
    run = run_of("legs-walk", *BRISK, METRICS)
    rates, angles = drawn("knees", run).axes
    assert rates.get_ylabel() == "knee rate (rad/s)"
    instants = [segment.end for segment in run.segments if segment.name != "all"]
    assert angles.get_xticks().tolist() == pytest.approx([0.0, *instants])
    left = next(line for line in angles.lines if line.get_label() == "left knee")
    assert np.min(left.get_ydata()) == pytest.approx(1.0, abs=0.1)


def test_ankle_is_drawn_as_a_half_sine(run_of):
    figure = drawn("ankle", run_of("legs-walk", *BRISK, METRICS))
    (path,) = figure.axes[0].lines
    x, z = path.get_data()
    np.testing.assert_allclose(z, 20.0 * np.sin(np.pi * x / 80.0), atol=1e-6)


def test_strip_has_the_instants_that_the_walk_reaches(run_of):
    figure = drawn("strip", run_of("legs-walk", *BRISK, METRICS))
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[0].startswith("(a)")
    assert len(titles) == 8


def test_balance_has_one_print_per_stand_and_the_bound(run_of):
    ground, over_time = drawn("balance", run_of("legs-walk", *BRISK, METRICS)).axes
    assert len(ground.patches) == 4  # both feet at the start, and two landings
    named = {text.get_text() for text in ground.get_legend().get_texts()}
    assert {"right foot", "left foot", "start", "end"} <= named
    bound = next(line for line in over_time.lines if line.get_linestyle() == "--")
    assert bound.get_ydata()[0] == pytest.approx(5.0)


def test_joints_are_drawn_with_torque(run_of):
    figure = drawn("joints", run_of("legs-walk", *BRISK, METRICS))
    assert figure.axes[-2].get_ylabel().startswith("knee torque")


def test_no_leg_hides_the_other_where_both_do_the_same(run_of):
    figure = drawn("joints", run_of("legs-squat", *BEND))
    titles = [axes.get_title(loc="left") for axes in figure.axes[:2]]
    assert titles == ["right leg", "left leg"]
    for axes in figure.axes:
        assert len([line for line in axes.lines if len(line.get_xdata()) > 2]) == 1
    for right, left in zip(figure.axes[::2], figure.axes[1::2], strict=True):
        assert right.get_ylim() == left.get_ylim()


def test_knee_bend_has_no_steps_to_draw(run_of):
    run = run_of("legs-squat", *BEND)
    assert drawn("strip", run) is None
    assert drawn("ankle", run) is None
    assert drawn("knees", run) is not None
    assert drawn("balance", run) is not None


def test_walks_side_by_side(run_of):
    runs = [run_of("legs-walk", *BRISK, METRICS)] * 2
    assert comparison_of(runs) is LEGS_COMPARISON
    with paper_style():
        figure = LEGS_COMPARISON.draw(runs, ["one", "other"])
    titles = [axes.get_title(loc="left").partition(": up to ")[0] for axes in figure.axes]
    assert titles == [
        "one",
        "other",
        "peak knee rate, at 1 kHz (rad/s)",
        "legs disagree by (mm)",
    ]


def test_walks_of_which_nothing_planned_is_asked_show_what_came_of_them(run_of):
    metrics = "metrics={fell: {segments: all}, tilt_max: {segments: all}}"
    runs = [run_of("legs-walk", *BRISK, metrics)] * 2
    with paper_style():
        figure = LEGS_COMPARISON.draw(runs, ["one", "other"])
    titles = [axes.get_title(loc="left").partition(": up to ")[0] for axes in figure.axes]
    assert titles == ["one", "other", "waist tilts by (deg)"]
    lean = np.degrees(metric_values(runs, "tilt_max")[0])
    assert [bar.get_width() for bar in figure.axes[-1].patches] == pytest.approx([lean, lean])
    untold = [run_of("legs-walk", *BRISK, "metrics={fell: {segments: all}}")] * 2
    with paper_style():
        figure = LEGS_COMPARISON.draw(untold, ["one", "other"])
    assert len(figure.axes) == 2, "no frame without anything in it"


def test_nothing_is_a_value_too(run_of):
    run = run_of("legs-walk", *BRISK, METRICS)
    assert metric_values([run], "fell").tolist() == [0.0]
    assert np.isnan(metric_values([run], "slip_max")).all()


def test_laws_are_told_apart_by_their_plans_whatever_is_measured(run_of):
    bare = "metrics={fell: {segments: all}}"
    runs = [run_of("legs-walk", *BRISK, bare, f"law={law}") for law in ("sc-trapezoid", "min-jerk")]
    assert LEGS_COMPARISON.tabulate is not None
    rows = {row["name"]: row["values"] for row in LEGS_COMPARISON.tabulate(runs, ["a", "b"])}
    assert list(rows)[-1] == "fell"
    peaks = [np.nan_to_num(value) for value in rows["peak_knee_rate"]]
    assert peaks[0] < peaks[1]
    with paper_style():
        figure = LEGS_COMPARISON.draw(runs, ["a", "b"])
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert "peak knee rate, at 1 kHz (rad/s)" in titles
