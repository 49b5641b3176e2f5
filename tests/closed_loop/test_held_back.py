"""A limit of the profile that holds the law back is named, and what is broken is not called so."""

import json

import numpy as np
import pytest
from pair_fault_bench import drawn, run
from stop_bench import CONFIGS

from rig.assembly import Backend
from rig.cli import invoke
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.run_facts import RunStatus

BARE = ("metrics={}", "figures=[]")


def ended(folder, *options, rig="cylinder"):
    """Run a step on the simulated rig; return the run and the causes that its log shows."""
    plan = load_plan("cylinder-step", (*options, *BARE), rig=rig, configs=CONFIGS)
    result = run_experiment(plan, Backend.SIM, folder, report=False)
    return result, causes_of(result.path)


def causes_of(folder):
    events = map(json.loads, (folder / "events.jsonl").read_text().splitlines())
    return [of for event in events for of in event.get("data", {}).get("causes", ())]


@pytest.mark.parametrize("seed", range(4))
def test_a_limit_that_holds_the_law_back_comes_first(tmp_path, capsys, seed):
    """Less than the seals need, whichever way the pair has to go first: so says the check, too."""
    chance = np.random.default_rng([1735, seed])
    base = chance.uniform(90.0, 130.0)
    most = base + chance.uniform(4.0, 7.0)  # they ask for some 20 kPa to either side
    size = 10.0 * chance.choice((-1.0, 1.0))
    narrow = (
        f"cylinder.limits.pressure=[0 kPa, {most:.1f} kPa]",
        f"cylinder.base_pressure={base:.1f} kPa",
    )
    words = [word for option in narrow for word in ("--set", option)]
    assert invoke(["check", "cylinder", "--configs", str(CONFIGS), *words]) == 0
    assert "leaves too little to either side of base_pressure" in capsys.readouterr().err
    step = (f"reference.size={size:g} mm", f"simulation.seed={seed}")
    result, causes = ended(tmp_path, *narrow, "cylinder.alarms.oscillation.lost=1 s", *step)
    assert result.status is RunStatus.FAULTED
    first = causes[0]
    assert first["cause"] == "held_back"
    assert first["of"] == ("agonist" if size > 0.0 else "antagonist")
    assert first["value"] == pytest.approx(1e3 * most, abs=60.0)
    assert invoke(["explain", str(result.path)]) == 0
    said = capsys.readouterr().out
    kinds = [line for line in said.splitlines() if line.startswith("kind: ")]
    assert kinds[0] == "kind: held_back"


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", ["stuck-at", "tube-off", "slow", "supply-lost"])
def test_what_is_broken_is_not_called_a_limit(tmp_path, kind, seed):
    result, _ = run(tmp_path, Backend.SIM, drawn(kind, 30 + seed), seed)
    assert result.status is RunStatus.FAULTED
    causes = causes_of(result.path)
    assert causes == [] or causes[0]["cause"] != "held_back"


def test_what_a_command_has_set_is_told_where_its_run_is_explained(tmp_path, capsys):
    setting = "cylinder.limits.following=0.2 mm"
    words = ["--set", setting, "--on", "sim", "--no-report", "--out", str(tmp_path)]
    assert invoke(["run", "cylinder-step", "--configs", str(CONFIGS), *words]) == 4
    capsys.readouterr()
    assert invoke(["explain", str(*tmp_path.iterdir())]) == 0
    assert f"by this run's command: {setting}" in " ".join(capsys.readouterr().out.split())
