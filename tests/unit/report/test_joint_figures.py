"""What the joint's figures show: every line of a kind is in the legend."""

from pathlib import Path

import pytest

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.mechanisms.joint.figures.tracking import draw_tensions
from rig.report.data import load_run
from rig.report.style import paper_style

CONFIGS = Path(__file__).parents[3] / "configs"
SHORT = [
    "reference.tones=[{frequency: 0.5 Hz, laps: 1}]", "approach=0.5 s",
    "metrics={tension_min: {min: 5 N}, tension_max: {max: 90 N}}",
]  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    plan = load_plan("joint-ideal-circle", SHORT, configs=CONFIGS)
    out = tmp_path_factory.mktemp("runs")
    return load_run(run_experiment(plan, Backend.SIM, out, report=False).path)


def test_bounds_of_the_tension_are_in_the_legend_once(run):
    with paper_style():
        axes = draw_tensions(run).axes[0]
    levels = [line.get_ydata()[0] for line in axes.lines if len(set(line.get_ydata())) == 1]
    assert levels == [5.0, 90.0]
    named = [text.get_text() for text in axes.get_legend().get_texts()]
    assert named == ["ch1", "ch2", "ch3", "ch4", "bound"]
