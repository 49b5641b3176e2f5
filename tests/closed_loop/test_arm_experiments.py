"""The arm's experiments as they are shipped: their own bounds are the promise.

On production drivers, emulated drives of both kinds of bus, and a plant with perturbed masses and
friction; and what is refused on the command line before anything moves.
"""

import json
from html import escape
from pathlib import Path

import pytest

from rig.assembly import Backend
from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment

CONFIGS = Path(__file__).parents[2] / "configs"
EXPERIMENTS = sorted(path.stem for path in (CONFIGS / "experiments").glob("arm-*.yaml"))
RIGS = ("arm", "arm-odrive")
IN_DEFAULT = {("arm-elbow-turnback", "arm-odrive", 1), ("arm-wrist-near-miss", "arm", -1)}


def result_of(folder, experiment, rig, *options):
    plan = load_plan(experiment, options, rig=rig, configs=CONFIGS)
    return run_experiment(plan, Backend.VIRTUAL, folder, report=False)


@pytest.mark.parametrize(
    ("experiment", "rig", "sign"),
    [
        pytest.param(*case, marks=() if case in IN_DEFAULT else pytest.mark.slow)
        for case in ((name, rig, sign) for name in EXPERIMENTS for rig in RIGS for sign in (1, -1))
    ],
)
def test_experiment_is_within_its_bounds(tmp_path, experiment, rig, sign):
    options = (f"arm.geometry.wrist_sign={sign}",)
    result = result_of(tmp_path, experiment, rig, *options)
    assert result.message is None
    missed = [metric for metric in result.metrics if metric.passed is False]
    assert not missed
    assert result.exit_code == 0
    bounded = {metric.name for metric in result.metrics if metric.bound is not None}
    assert {"path_deviation", "path_deviation_measured"} <= bounded
    assert bounded & {"peak_rate_arm", "peak_rate_share"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("rig", RIGS)
def test_another_arm_of_the_same_kind_is_within_them_too(tmp_path, rig, seed):
    result = result_of(tmp_path, "arm-elbow-turnback", rig, f"simulation.seed={seed}")
    assert [metric.name for metric in result.metrics if metric.passed is False] == []


def test_weak_drives_follow_what_is_timed_under_their_torques_and_nothing_faster(tmp_path):
    plan = load_plan("arm-path-loaded", (), rig=None, configs=CONFIGS)
    result = run_experiment(plan, Backend.VIRTUAL, tmp_path, report=True)
    assert [metric.name for metric in result.metrics if metric.passed is False] == []
    assert result.exit_code == 0
    drawn = {path.stem for path in tmp_path.glob("**/figures/*.png")}
    page = (result.path / "report.html").read_text()
    assert plan.motion.remarks
    for kind, said in plan.motion.remarks:
        assert escape(kind) in page and escape(said) in page, "the report has the singularities"
    assert {"torques", "accelerations", "arm"} <= drawn
    free = result_of(tmp_path, "arm-path-loaded", None, "reference.torques=false")
    missed = {metric.name for metric in free.metrics if metric.passed is False}
    assert {"path_deviation_measured", "peak_torque_share"} <= missed


@pytest.mark.slow
def test_dwell_of_the_taylor_expansion_is_as_much_too_short_as_it_says(tmp_path):
    result = result_of(tmp_path, "arm-elbow-dwell", "arm", "controller=esc-paper")
    values = {metric.name: metric.value for metric in result.metrics}
    assert values["dwell_time"] == pytest.approx(3.9996, abs=1e-4)
    assert values["dwell_time_measured"] == pytest.approx(3.9996, abs=2e-3)


REFUSED = [
    # experiment, option, words: each with its number
    ("turnback", "reference.speed=0.7 m/s", ("sin q_s = 5.3173", "at least 5.3174 rad/s")),
    ("dwell", "reference.dwell=8 s", ("dwells at most 4.196 s",)),
    ("turnback", "reference.travel=0.1 m", ("0.79 m from the shoulder", "within 0.1 m")),
    (
        "turnback",
        "reference.start=[0 deg, 60 deg, 20 deg, 30 deg, -50 deg, 0 deg]",
        ("inside the region", "|S3| = 0.3420", "sin q_s = 0.5317"),
    ),
    (
        "turnback",
        "reference={kind: arm-turnback, start: [0 deg, 90 deg, 0 deg, 30 deg, -50 deg, 0 deg],"
        " direction: [0, 0, 1]}",
        ("S3 = 0", "tangential", "radial share"),
    ),
    (
        "turnback",
        "arm.geometry.position_min=[-3 rad, -3 rad, -0.5 rad, -6 rad, -2.5 rad, -6 rad]",
        ("after 5.995 s q3 would be at -28.71 deg", "-28.65 to 160.43 deg"),
    ),
    (
        "circle",
        "reference.rate=3 rad/s",
        ("q3 would need 2.76", "limit of 1 rad/s", "round the circle it would fit"),
    ),
    ("dwell", "reference.depth=0.79 m", ("0.79 m", "no less than 0.78 m", "folded")),
]


@pytest.mark.parametrize(
    ("experiment", "option", "words"), REFUSED, ids=lambda case: str(case)[:32]
)
def test_what_cannot_be_done_is_refused_before_anything_moves(
    tmp_path, capsys, experiment, option, words
):
    code = invoke(
        ["run", f"arm-elbow-{experiment}", "--controller", "esc-paper", "--set", option,
         "--configs", str(CONFIGS), "--out", str(tmp_path / "runs")]
    )  # fmt: skip
    said = capsys.readouterr().err
    assert code == 2
    for word in words:
        assert word in said
    assert not (tmp_path / "runs").exists(), "nothing was opened, nothing recorded"


@pytest.mark.slow
def test_compare_tells_who_refuses_and_where_the_papers_law_loses(tmp_path, capsys):
    code = invoke(
        ["compare", "arm-shoulder-near-miss", "--controllers", "servo-halt,esc-paper,look-ahead",
         "--set", "reference.before=0.1 m", "--set", "reference.after=0.1 m", "--json",
         "--configs", str(CONFIGS), "--out", str(tmp_path)]
    )  # fmt: skip
    table = json.loads(capsys.readouterr().out)
    rows = {row["name"]: dict(zip(table["labels"], row["values"], strict=True))
            for row in table["metrics"]}  # fmt: skip
    assert code == 0
    assert rows["ends"] == {"servo-halt": "halts", "esc-paper": "done", "look-ahead": "done"}
    assert rows["time_over_optimum"]["servo-halt"] is None
    assert (
        rows["time_over_optimum"]["esc-paper"] > 1.5 > 1.1 > rows["time_over_optimum"]["look-ahead"]
    )
    assert max(rows["path_deviation"][law] for law in ("esc-paper", "look-ahead")) < 1e-5


@pytest.mark.slow
def test_compare_has_a_column_for_a_law_that_refuses(tmp_path, capsys):
    code = invoke(
        ["compare", "arm-elbow-dwell", "--controllers", "esc-paper,look-ahead", "--json",
         "--configs", str(CONFIGS), "--out", str(tmp_path)]
    )  # fmt: skip
    captured = capsys.readouterr()
    table = json.loads(captured.out)
    assert code == 0
    assert "look-ahead: refused:" in captured.err
    assert "cannot dwell 4 s" in table["refused"]["look-ahead"]
    ends = next(row for row in table["metrics"] if row["name"] == "ends")
    assert dict(zip(table["labels"], ends["values"], strict=True)) == {
        "esc-paper": "done",
        "look-ahead": "refuses",
    }
