"""`rig check` shows every rig that is shipped, whatever its buses are."""

import json
import re
from pathlib import Path

import pytest

import rig
from rig.assembly import REGISTRY, Backend, build_rig
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.hal import ConfigurationError

AREA, BREAKAWAY = 1.8143e-4, 12.5
"""Of the shipped cylinder, m² and N."""
CONFIGS = Path(__file__).parents[2] / "configs"
RIGS = sorted(path.stem for path in (CONFIGS / "rigs").glob("*.yaml"))


@pytest.mark.parametrize("name", RIGS)
def test_every_rig_is_shown_to_people_and_to_programs(capsys, name):
    assert invoke(["check", name, "--configs", str(CONFIGS)]) == 0
    assert f"rig {name}" in capsys.readouterr().out
    assert invoke(["check", name, "--configs", str(CONFIGS), "--json"]) == 0
    profile = json.loads(capsys.readouterr().out)["profile"]
    assert profile["name"] == name
    for bus in profile["buses"]:
        assert bus["interface"]
        assert bus["channel"]
        assert bus["bitrate"] > 0
        assert 0.0 < bus["load"] <= bus["max_load"]


@pytest.mark.parametrize("name", RIGS)
def test_check_says_what_a_cut_wire_comes_to_and_what_an_alarm_is(capsys, name):
    """Servos have no wires."""
    assert invoke(["check", name, "--configs", str(CONFIGS)]) == 0
    shown = capsys.readouterr().out
    assert invoke(["check", name, "--configs", str(CONFIGS), "--json"]) == 0
    expected = json.loads(capsys.readouterr().out)["profile"]["expected"]
    pneumatic = name.startswith(("cylinder", "joint"))
    assert [item["unit"] for item in expected] == (
        [
            "m/s", "J", "Pa", "m/s", "J", "J", "Pa", "N s/m", "N", "Pa", "s", "Pa", "s", "Pa", "1",
            "Pa",
        ]
        if pneumatic
        else []
    )  # fmt: skip
    assert ("what to expect if a part breaks" in shown) is pneumatic
    assert all(item["name"] in shown for item in expected)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "arm-puma-560",
            {
                "singular at the shoulder": "wrist centre 150 mm from the axis of q1",
                "singular at the elbow": "q3 at -2.692 deg, where the arm is stretched",
                "singular at the wrist": "q5 at 0 deg",
                "reach": "wrist centre 311.8 mm to 864.1 mm from the shoulder",
                "q4 of the laws": "-110 to 170 deg, at most 114.6 deg/s",
            },
        ),
        (
            "legs",
            {
                "legs": "200 mm from hip to ankle with straight knees",
                "soles": "58.2 mm ahead of the ankle, 35.8 mm behind it, 62 mm wide",
                "hip_yaw": "left -30 to 90 deg, right -90 to 30 deg",
            },
        ),
    ],
)
def test_check_says_how_far_a_rig_reaches_and_where_it_is_singular(capsys, name, said):
    assert invoke(["check", name, "--configs", str(CONFIGS), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["profile"]["dimensions"]
    assert invoke(["check", name, "--configs", str(CONFIGS)]) == 0
    shown = capsys.readouterr().out
    for what, value in said.items():
        assert value in told[what]
        assert told[what] in shown


def warnings_of(capsys, *words):
    """Return what `rig check` warns of, and holds it against what a person is shown."""
    capsys.readouterr()
    assert invoke(["check", *map(str, words), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["warnings"]
    assert invoke(["check", *map(str, words)]) == 0
    err = capsys.readouterr().err.splitlines()
    assert [line for line in err if line.startswith("warning")] == [f"warning: {s}" for s in told]
    return told


def test_a_cut_wire_beyond_the_limit_is_warned_of_with_the_pressure_that_keeps_it(capsys):
    assert warnings_of(capsys, "cylinder") == []
    [sentence] = warnings_of(capsys, "cylinder", "--set", "cylinder.base_pressure=150 kPa")
    assert "above limits.speed, 500 mm/s" in sentence and "(it is 150 kPa)" in sentence
    calm = re.search(r"base_pressure of at most ([\d.]+) kPa", sentence)[1]
    assert warnings_of(capsys, "cylinder", "--set", f"cylinder.base_pressure={calm} kPa") == []
    more = f"cylinder.base_pressure={float(calm) + 0.1} kPa"
    assert len(warnings_of(capsys, "cylinder", "--set", more)) == 1


def test_a_pressure_that_moves_nothing_is_not_recommended(capsys):
    """Of a third of the speed, and of all at which a lower pressure still moves the pair."""
    for speed, is_moved in ((150, False), (200, False), (400, True)):
        words = ["--set", f"cylinder.limits.speed={speed} mm/s"]
        sentence = next(s for s in warnings_of(capsys, "cylinder", *words) if "limits.speed" in s)
        calm = float(re.search(r"base_pressure .*?([\d.]+) kPa \(it is 95 kPa\)", sentence)[1])
        assert ("of at most" in sentence) is is_moved
        pull = 2.0 * AREA * (calm - 20.0) * 1e3
        assert (pull >= 1.6 * BREAKAWAY) is is_moved
        if not is_moved:
            assert "too low to move the seals" in sentence and f"{BREAKAWAY:g} N" in sentence
            told = float(re.search(r"leaves a pair ([\d.]+) N", sentence)[1])
            assert told == pytest.approx(pull, rel=1e-3)
            assert "a damper of " in sentence and "(limits.stop_energy)" in sentence


def test_a_pressure_that_a_run_refuses_is_refused_here_in_the_same_words(capsys):
    words = ["--set", "cylinder.base_pressure=18 kPa"]
    said = []
    for command in (["run", "cylinder-step"], ["check", "cylinder-step"], ["check", "cylinder"]):
        assert invoke([*command, *words]) == 2
        said.append(capsys.readouterr().err.replace("cylinder-step:", "cylinder:"))
    assert "leaves no differential between the pressure floor" in said[0]
    assert said == said[:1] * 3
    with pytest.raises(ConfigurationError, match="leaves no differential"):
        rig.check("cylinder", set={"cylinder.base_pressure": 18e3})
    held = ["--set", "controllers.cascade.pressure_floor=10 kPa"]
    assert invoke(["check", "cylinder", *words, *held]) == 0


def bored(folder, *lines):
    """Write a rig of another bore than the one that it extends."""
    rig = folder / "bored.yaml"
    plant = "plant:\n  cylinder: {bore: 20 mm}\n"
    rig.write_text("\n".join(["extends: cylinder", "cylinder:", "  bore: 20 mm", *lines, plant]))
    return rig


def test_what_a_rig_of_another_bore_has_from_its_parent_is_told(tmp_path, capsys):
    rig = bored(tmp_path, "  base_pressure: 58 kPa")
    sentence, limits = warnings_of(capsys, rig)
    assert limits.startswith("limits.pair_force: from ")
    assert "friction, moving_mass and the gains of pid, pid-friction, cascade: from " in sentence
    assert "cylinder.yaml, where cylinder.bore is 16 mm (20 mm here)" in sentence
    assert f"Next: rig calibrate {rig} --all, then rig tune {rig}" in sentence


def test_of_what_is_measured_in_part_the_key_is_named_that_nobody_has_measured(tmp_path, capsys):
    own = [
        "  base_pressure: 58 kPa",
        "  moving_mass: 0.14 kg",
        "  friction: {coulomb: 9 N, breakaway: 9 N, viscous: 50}",
    ]
    sentence, _ = warnings_of(capsys, bored(tmp_path, *own))
    assert sentence.startswith("friction.stribeck_velocity and the gains of pid, ")
    assert sentence.endswith(
        "What of friction.stribeck_velocity no calibration finds is yours to write"
    )


def test_what_a_rig_says_itself_is_not_its_parents(tmp_path, capsys):
    own = [
        "  base_pressure: 58 kPa",
        "  moving_mass: 0.14 kg",
        "  friction: {coulomb: 9 N, breakaway: 9 N, stribeck_velocity: 8 mm/s, viscous: 50}",
        "  limits: {pair_force: 90 N}",
    ]
    rig = bored(tmp_path, *own)
    [sentence] = warnings_of(capsys, rig)
    assert sentence.startswith("the gains of pid, ") and sentence.endswith(f"rig tune {rig}")
    assert "calibrate" not in sentence
    same = tmp_path / "same.yaml"
    plant = "plant: {home: 29 mm}\n"
    same.write_text(f"extends: cylinder\ncylinder:\n  bore: 1.6 cm\n  home: 29 mm\n{plant}")
    assert warnings_of(capsys, same) == []


@pytest.mark.parametrize(
    ("rig", "plant"), [("cylinder", "spherical-joint"), ("arm", "legs"), ("legs", "arm")]
)
def test_the_plant_of_another_mechanism_is_refused_before_anything_runs(capsys, rig, plant):
    of = ["check", rig, "--configs", str(CONFIGS), "--set", f"plant.model={plant}"]
    assert invoke(of) == 2
    assert f"plant.model {plant} is no plant of the mechanism {rig}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("experiment", "known"),
    [("cylinder-ideal-sine", True), ("joint-circle", True), ("arm-elbow-circle", False)],
)
def test_check_says_how_near_a_loop_is_to_instability_where_that_is_known(
    capsys, experiment, known
):
    assert invoke(["check", experiment, "--configs", str(CONFIGS)]) == 0
    shown, said = capsys.readouterr()
    assert ("the loop that" in shown) is known
    assert ("friction only" in said) == ("friction holds it" in shown)
    assert ("`rig tune cylinder" in said) is (experiment == "cylinder-ideal-sine")
    assert invoke(["check", experiment, "--configs", str(CONFIGS), "--json"]) == 0
    loop = json.loads(capsys.readouterr().out)["experiment"]["loop"]
    assert (loop is not None) is known
    if loop is not None:
        assert set(loop) == {"stable", "crossover", "phase", "delay", "sensitivity"}
        assert (loop["phase"] > 0.0) == loop["stable"]
        assert ("friction holds it" in shown) != loop["stable"]


@pytest.mark.parametrize(("key", "value"), [("bore", "25 mm"), ("rod", "8 mm")])
def test_a_simulated_cylinder_of_another_width_is_refused(capsys, key, value):
    said = ["--set", f"cylinder.{key}={value}"]
    assert invoke(["check", "cylinder", *said]) == 2
    assert f"plant.cylinder.{key} is" in capsys.readouterr().err
    assert invoke(["check", "cylinder", *said, "--set", f"plant.cylinder.{key}={value}"]) == 0


@pytest.mark.parametrize("rig", ["legs", "legs-can"])
def test_simulated_legs_that_begin_higher_than_they_reach_are_refused(capsys, rig):
    """They were a ValueError of the plant when they were run."""
    said = [f"--set=legs.geometry.{link}=92 mm" for link in ("thigh", "shank")]
    assert invoke(["check", rig, *said]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "plant.initial_hip_height is 190 mm by default" in told
    assert "it can be 0 … 184 mm" in told
    assert invoke(["check", rig, *said, "--set", "plant.initial_hip_height=175 mm"]) == 0
    assert invoke(["check", rig]) == 0


@pytest.mark.parametrize(
    ("words", "near"),
    [
        (["list", "rnus"], "runs"),
        (["new", "rg", "mine"], "rig"),
        (["run", "cylinder-sine", "--on", "simm"], "sim"),
        (["export", "latest", "--format", "cvs"], "csv"),
    ],
)
def test_a_mistyped_word_of_a_few_is_told_the_nearest(capsys, words, near):
    assert invoke(words) == 2
    assert re.search(f"Did you mean '?{near}'?\\?", capsys.readouterr().err)


@pytest.mark.parametrize("on", ["sim", "virtual"])
def test_a_load_cell_at_a_cylinder_is_simulated(tmp_path, monkeypatch, on):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "celled.yaml").write_text(
        "extends: cylinder\nloop: {rate: 500 Hz}\ndevices:\n  rod-force:\n    driver: load-cells\n"
        "    bus: can0\n    node: 0x30\n    cells:\n"
        "      agonist: {sub: 1, raw: [0, 32767], force: [-50 N, 300 N]}\n"
    )
    assert invoke(["run", "cylinder-step", "--on", on, "--rig", "celled.yaml", "--no-report"]) == 0


def test_a_cell_at_a_cylinder_shows_the_force_in_its_wire():
    profile = load_profile("cylinder", REGISTRY, (), find_configs())
    rig = build_rig(profile, Backend.SIM)
    plant = rig.clock.world
    plant.set_supply(True)
    for channel, pressure in enumerate((200e3, 150e3)):
        plant.set_pressure_setpoint(channel, pressure)
    plant.advance(1.0)
    names = [name for name, _ in plant.truth_columns]
    for channel, name in enumerate(plant.channel_names):
        force = plant.truth()[names.index(f"tension_{name}")]
        assert plant.channel_value(channel) == pytest.approx(force, abs=1.0)
        assert force > 10.0


def test_an_arms_branch_and_singularities_are_told_with_the_reason(capsys):
    path = ("check", "arm-path", "--configs", str(CONFIGS))
    assert invoke([*path]) == 0
    out = capsys.readouterr().out
    assert "on the branch reaching ahead, elbow +, wrist -" in out
    assert "through: the tool is in line with the forearm and q5 changes its sign" in out
    # A range that the branch of `near` does not keep: the elbow has to bend the other way.
    low = "arm.geometry.position_min=[-6.2, -6.2, -2.8, -6.2, -2.5, -6.2]"
    high = "arm.geometry.position_max=[6.2, 6.2, 0, 6.2, 2.5, 6.2]"
    assert invoke([*path, "--set", low, "--set", high, "--json"]) == 0
    remarks = json.loads(capsys.readouterr().out)["experiment"]["remarks"]
    told = {remark["kind"]: remark["message"] for remark in remarks}
    assert "elbow -" in told["begins"]
    assert re.search(
        r"elbow -.*: from the nearest beginning.* q3 would be at \d+\.\d+ deg, outside its range",
        told["chosen"],
    )


TREAD = "{foot: left, x: 100 mm, y: 39 mm, height: 10 mm}"


@pytest.mark.parametrize(
    ("experiment", "options", "told"),
    [
        ("arm-path-loaded", [], []),
        (
            "arm-path-loaded",
            ["plant.links.payload=1 kg", "plant.links.masses=[6, 5, 4, 1, 1, 0.5]"],
            [
                r"payload of 3 kg .* carries 1 kg \(plant.links.payload\)",
                r"3.2 kg of the forearm .* 4 kg \(plant.links.masses\)",
            ],
        ),
        ("arm-path-loaded", ["rig=arm"], [r"payload of 3 kg .* carries 0.5 kg"]),
        (
            "arm-path-loaded",
            ["plant.drives.torque_limits=[40, 70, 48, 8, 8, 5]"],
            [r"75 N m of q2 .* has 70 N m \(plant.drives.torque_limits\)"],
        ),
        (
            "legs-footsteps",
            [f"reference.steps=[{TREAD}]"],
            [r"step 1 is planned to land 10 mm above .* level with the start \(plant.terrain\)"],
        ),
        (
            "legs-footsteps",
            [
                f"reference.steps=[{TREAD}]",
                "plant.terrain=[{start: 61 mm, length: 200 mm, height: 10 mm}]",
            ],
            [r"swing left 1, 11 % of the way, would bring the sole \S+ mm into the simulated"],
        ),
        (
            "legs-footsteps",
            [
                f"reference.steps=[{TREAD}]",
                "plant.terrain=[{start: 61 mm, length: 200 mm, height: 10 mm}]",
                "reference.lift=35 mm",
            ],
            [],
        ),
    ],
)
def test_what_a_simulated_rig_has_otherwise_than_its_plan_is_told(
    capsys, experiment, options, told
):
    """A walk onto a tread that is not simulated fell, and was told as a joint that lags."""
    sets = [word for option in options for word in ("--set", option)]
    assert invoke(["check", experiment, "--configs", str(CONFIGS), "--json", *sets]) == 0
    found = json.loads(capsys.readouterr().out)["experiment"]["simulated_otherwise"]
    assert len(found) == len(told), found
    assert all(re.search(words, one) for words, one in zip(told, found, strict=True)), found


def test_a_name_that_a_rig_and_an_experiment_have_is_the_one_that_is_asked_for(capsys):
    invoke(["check", "legs-push"])
    told = capsys.readouterr()
    assert "# rig legs-push" in told.out and "# experiment" not in told.out
    assert re.search(r"an experiment of that name is \S*legs-push\.yaml", told.err)
    for asked in (["--set", "reference.speed=4"], ["--set", "metrics={}"]):
        assert invoke(["check", "legs-push", *asked]) == 0
        told = capsys.readouterr()
        assert "# experiment legs-push" in told.out and "of that name" not in told.err
    invoke(["check", "legs-push", "--set", "legs.start_tilt=3 deg"])
    assert "# experiment" not in capsys.readouterr().out
