"""Down treads on the simulated robot: what servos yield makes it fall, and what is said of that."""

import re

from legs_bench import CONFIGS

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.explaining.ended_run import explain_run

TREADS = ((61, 10), (161, 20), (261, 10))
PRINTS = ((0, 0), (100, 10), (200, 20), (300, 10), (400, 0))


def stairs(tmp_path, *, sag):
    """Return a plan over two treads up and two down, first with the feet brought closer by 6 mm."""
    prints = tmp_path / "prints.csv"
    rows = [
        f"{foot}, {x}, {y}, {z}" for x, z in PRINTS for foot, y in (("left", 45), ("right", -40))
    ]
    prints.write_text("\n".join(["foot, x (mm), y (mm), height (mm)", *rows]))
    terrain = ", ".join(f"{{start: {x} mm, length: 100 mm, height: {z} mm}}" for x, z in TREADS)
    return load_plan(
        "legs-stairs",
        [
            "reference.numbers=null",
            f"reference.file={prints}",
            f"plant.terrain=[{terrain}]",
            f"legs.sag={sag}",
        ],
        configs=CONFIGS,
    )


def run_of(tmp_path, **options):
    return run_experiment(stairs(tmp_path, **options), Backend.SIM, tmp_path, report=False)


def test_feet_that_servos_let_down_beside_their_prints_fall_and_it_is_said_where(tmp_path):
    result = run_of(tmp_path, sag="null")
    assert result.exit_code in (1, 4)
    told = {remark.label: remark.text for remark in explain_run(result.path)}
    words = (
        r"the robot fell after (\d+\.\d+) s \((.*)\); from (\d+\.\d+) s \(.*\) on its (right|left)"
    )
    fell, phase, since, _ = re.match(words, told["fell"]).groups()
    assert float(since) < float(fell)
    assert re.match(r"(swing|shift) ", phase)
    assert "on an edge" in told["fell"]


def test_with_what_they_yield_commanded_beforehand_it_stands_on_every_tread(tmp_path):
    plan = stairs(tmp_path, sag="{}")
    result = run_experiment(plan, Backend.SIM, tmp_path, report=False)
    values = {metric.name: metric.value for metric in result.metrics}
    assert values["fell"] == 0.0
    assert values["saturated_share"] == 0.0
    assert values["feet_astray_end"] < 10e-3
