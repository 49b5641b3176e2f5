"""`rig calibrate` from the command line to the file, and back into a profile."""

import json
import re
import shlex
import shutil

import pytest

from rig.calibration import store
from rig.cli import invoke
from rig.config import find_configs
from rig.config.quantities import parse_quantity


@pytest.fixture
def configs(tmp_path):
    source = find_configs()[-1] / "rigs" / "cylinder.yaml"
    folder = tmp_path / "configs"
    (folder / "rigs").mkdir(parents=True)
    (folder / "rigs" / "cylinder.yaml").write_text(source.read_text(encoding="utf-8"))
    return folder


@pytest.fixture
def no_page(monkeypatch):
    """Draw no page where none is looked at: it takes a second."""
    monkeypatch.setattr("rig.calibration.session.draw_page", lambda *_: [])


def calibrate(configs, *words):
    out = ["--configs", str(configs), "--out", str(configs.parent / "runs")]
    return invoke(["calibrate", "cylinder", *words, *out])


def test_a_procedure_from_preview_to_use(configs, capsys):
    file = configs / "calibration" / "cylinder" / "cylinder.yaml"
    assert calibrate(configs, "response", "--dry-run") == 0
    shown = capsys.readouterr().err
    assert "chamber 1: set-points 95 kPa … 135 kPa" in shown
    assert "limits.position -20 mm … 20 mm" in shown
    assert not file.exists()
    assert not (configs.parent / "runs").exists()

    assert calibrate(configs, "response", "--yes", "--on", "sim", "--temperature", "23 degC") == 0
    shown, said = capsys.readouterr()
    assert "bears more dead time" in shown, "what the loops bear, now that it is known"
    found = store.load(file)
    response, reason = found["values"]["regulator_response"], found["reasons"]
    assert response["dead_time"].endswith(" s") and response["bandwidth"].endswith(" rad/s")
    why = reason["regulator_response.dead_time"]
    assert f"put in force: regulator_response.dead_time {response['dead_time']}: {why}" in said
    each = re.findall(r"(?:ant)?agonist (?:up|down) ([0-9.]+ ms)", why)
    longest = max(parse_quantity(text, "s") for text in each)
    assert len(each) == 4
    assert parse_quantity(response["dead_time"], "s") == pytest.approx(longest, rel=5e-3)
    estimated = [m["value"] for m in found["measured"] if m["name"].endswith(".dead_time")]
    assert longest > 1.05 * max(estimated), "or it need not be said"

    rig = configs / "rigs" / "cylinder.yaml"  # where nobody who leaves --configs out would find it
    assert f"`rig tune {rig} --controller pid`" in said
    (run,) = (configs.parent / "runs").iterdir()
    assert (run / "figures" / "calibration-response.png").stat().st_size > 10_000
    assert json.loads((run / "manifest.json").read_text())["status"] == "ok"
    assert invoke(["check", "cylinder", "--configs", str(configs), "--json"]) == 0
    (state,) = json.loads(capsys.readouterr().out)["profile"]["calibrations"]
    assert (state["name"], state["procedure"], state["state"]) == ("cylinder", "response", [])

    bore = ["--set", "cylinder.bore=25 mm", "--set", "plant.cylinder.bore=25 mm"]
    assert invoke(["check", "cylinder", "--configs", str(configs), "--json", *bore]) == 0
    (state,) = json.loads(capsys.readouterr().out)["profile"]["calibrations"]
    told = "was found with cylinder.bore 16 mm, and the profile says 25 mm"
    assert (state["state"], "response --replace" in state["remedy"]) == ([told], True)

    assert calibrate(configs, "--history", "cylinder") == 0
    assert len(capsys.readouterr().out.strip().splitlines()) == 4  # and the profile
    assert calibrate(configs, "--diff", "cylinder", "cylinder") == 0
    assert "agonist.bandwidth" in capsys.readouterr().out


@pytest.mark.usefixtures("no_page")
def test_what_is_broken_off_changes_nothing_and_can_be_gone_on_with(configs, capsys):
    stop = "simulation.faults=[{at: 5, device: regulators, fault: emergency_stop}]"
    code = calibrate(configs, "response", "--yes", "--on", "sim", "--set", stop)
    told = capsys.readouterr().err
    assert code == 4
    assert "nothing was changed; what was recorded is kept" in told
    assert not (configs / "calibration").exists()
    (run,) = (configs.parent / "runs").iterdir()
    assert f"--from {run}" in told

    assert calibrate(configs, "response", "--yes", "--on", "sim", "--from", str(run)) == 0
    runs = sorted((configs.parent / "runs").iterdir())
    assert len(runs) == 2
    text = (configs / "calibration" / "cylinder" / "cylinder.yaml").read_text()
    assert all(f"{path}/log.mcap" in " ".join(text.split()) for path in runs)


def test_readings_that_are_none_are_refused_before_anything_moves(configs, capsys):
    file = configs / "readings.csv"
    file.write_text("caliper agonist,nowhere,3 mm\ncaliper,1,2 mm\n")
    assert calibrate(configs, "encoders", "--yes", "--on", "sim", "--readings", str(file)) == 2
    assert "readings.csv:2:1: " in capsys.readouterr().err
    assert not (configs.parent / "runs").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "procedure"),
    [("legs-balance", "scale"), ("cylinder-valves", "encoders"), ("cylinder", "encoders")],
)
def test_what_a_rig_is_fed_and_felt_by_stands_in_no_procedures_way(
    tmp_path, capsys, rig, procedure
):
    """A jig presses no sole; a PID bears the dead time of valves and of real regulators."""
    configs = tmp_path / "configs"
    shutil.copytree(find_configs()[-1] / "rigs", configs / "rigs")
    places = ["--configs", str(configs), "--out", str(tmp_path / "runs")]
    assert invoke(["calibrate", rig, procedure, "--yes", "--on", "sim", *places]) == 0
    assert "faulted" not in capsys.readouterr().err
    assert list((configs / "calibration" / rig).glob("*.yaml"))


def test_the_lens_is_found_from_views_of_a_board_and_written(tmp_path, capsys):
    shutil.copytree(find_configs()[-1] / "rigs", tmp_path / "configs" / "rigs")
    where = ("--configs", str(tmp_path / "configs"), "--out", str(tmp_path / "runs"))
    assert invoke(["calibrate", "joint", "lens", "--yes", "--on", "sim", *where]) == 0
    assert "fx" in capsys.readouterr().out
    assert (tmp_path / "configs" / "calibration" / "joint" / "camera.yaml").exists()


def test_nobody_to_ask_is_told(configs, capsys):
    assert calibrate(configs, "response", "--on", "sim") == 2
    assert "say --yes" in capsys.readouterr().err
    assert calibrate(configs, "respons", "--yes") == 2
    assert "did you mean response?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rig", "procedure", "moves"),
    [
        ("joint", "geometry", "the ring leans by up to 41.83 deg, at up to "),  # 0.73 rad
        ("joint", "camera", "the ring leans by up to 34.38 deg, at up to "),  # 0.6 rad
        ("joint", "encoders", "the ring leans by up to 27 deg, at up to "),  # 0.45 of 60
        ("joint", "friction", "36 times one pair is"),
        ("joint", "wires", "no rod is meant to move"),
        ("joint-locked", "leak", "the ring leans by up to 33.75 deg, at up to "),
        ("cylinder", "encoders", "the pair moves -12 mm … 12 mm, up to "),
        ("arm", "zeros", "q1 moves -28.65 deg … 28.65 deg from where it stands, up to "),
        ("legs", "zeros", "nothing moves by itself"),
    ],
)
def test_a_preview_says_what_moves_and_how_far(rig, procedure, moves, capsys):
    assert invoke(["calibrate", rig, procedure, "--dry-run"]) == 0
    assert moves in capsys.readouterr().err


@pytest.mark.usefixtures("no_page")
def test_another_seed_is_another_rig_of_whatever_is_said(configs, capsys):
    """What the seed draws is another rig; the file keeps which it was."""
    file = configs / "calibration" / "cylinder" / "cylinder.yaml"
    found = {}
    for seed in ("3", "4"):
        assert calibrate(configs, "response", "--yes", "--on", "sim", "--seed", seed) == 0
        assert f"seed: {seed}" in file.read_text()
        found[seed] = capsys.readouterr().out
    assert found["3"] != found["4"]


def test_what_was_broken_off_goes_on_with_its_seed(configs, capsys):
    stop = "simulation.faults=[{at: 5, device: regulators, fault: emergency_stop}]"
    words = ("response", "--yes", "--on", "sim", "--set", stop)
    assert calibrate(configs, *words, "--seed", "3") == 4
    (run,) = (configs.parent / "runs").iterdir()
    (line,) = [one for one in capsys.readouterr().err.splitlines() if "go on with: " in one]
    command = shlex.split(line.partition("go on with: ")[2])
    given = {"--on": "sim", "--seed": "3", "--set": stop, "--from": str(run)}
    for option, value in given.items():
        assert command[command.index(option) + 1] == value, command
    assert command[:2] == ["rig", "calibrate"] and command[3] == "response"


@pytest.mark.usefixtures("no_page")
def test_the_loops_are_shown_once_after_all_procedures(configs, capsys):
    assert calibrate(configs, "wires", "response", "--yes", "--on", "sim") == 0
    shown = capsys.readouterr().out
    assert shown.count("# loops of cylinder, linear") == 1
    assert shown.index("# loops of") > shown.index("dead_time"), "after what the last has found"


@pytest.mark.usefixtures("no_page")
def test_an_interruption_after_the_recording_says_how_to_go_on(configs, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    words = ("response", "--yes", "--on", "sim", "--set", "loop.longest_motion=1000 s")
    with monkeypatch.context() as patch:
        patch.setattr("rig.calibration.session.conclude", interrupted)
        assert calibrate(configs, *words) == 130
    told = capsys.readouterr().err
    assert not (configs / "calibration").exists()
    command = shlex.split(told.partition("go on with: ")[2])
    assert command[:2] == ["rig", "calibrate"]
    assert invoke([*command[1:], "--yes"]) == 0
    assert (configs / "calibration" / "cylinder" / "cylinder.yaml").exists()
    assert len([*(configs.parent / "runs").iterdir()]) == 1, "nothing was recorded again"
