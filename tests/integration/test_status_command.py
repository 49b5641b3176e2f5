"""`rig status`: every stage of a rig on its way to hardware, and the command that comes next."""

import json
import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from click.testing import CliRunner

from rig.calibration import store
from rig.cli.commands import invoke
from rig.cli.status import status
from rig.commissioning.record import CommissioningState
from rig.doctor.look import Fitness, Look
from rig.experiment.fault_latch import FaultLatch
from rig.tuning.attempt import keep_attempt

COMMISSIONS = True
CONFIGS = Path(__file__).parents[2] / "configs"
TODAY = datetime.now(UTC)
PROCEDURES = {
    "regulators": ("regulators",),
    "encoders": ("encoder-agonist", "encoder-antagonist"),
    "wires": ("cylinder",),
    "response": ("cylinder",),
    "friction": ("cylinder",),
    "leak": ("cylinder",),
}


@pytest.fixture
def configs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a name is found here
    shutil.copytree(
        CONFIGS, tmp_path / "configs", ignore=shutil.ignore_patterns("calibration", "commissioning")
    )
    return tmp_path / "configs"


@pytest.fixture(autouse=True)
def wired(monkeypatch):
    """Take the CAN interfaces for up: no test has them."""
    monkeypatch.setattr("rig.doctor.wiring.look_at_wiring", lambda _: iter(()))


def keep(configs, *procedures, backend="hardware", days=365):
    """Write calibrations that change nothing, as of so many procedures."""
    until = (TODAY + timedelta(days=days)).date().isoformat()
    date = TODAY.isoformat(timespec="seconds")
    for target in {target for name in procedures for target in PROCEDURES[name]}:
        measured = [
            {"name": name, "value": 1.0, "unit": "1", "std": 0.1, "interval": [0.8, 1.2],
             "procedure": name, "backend": backend, "date": date, "valid_until": until}
            for name in procedures
            if target in PROCEDURES[name]
        ]  # fmt: skip
        provenance = {
            "procedure": procedures[-1], "date": date, "operator": "nobody", "backend": backend,
            "valid_until": until,
        }  # fmt: skip
        content = {"values": {}, "measured": measured, "provenance": provenance}
        store.write(configs, "cylinder", target, content)


def show(configs, *words):
    result = CliRunner().invoke(
        status, ["cylinder", "--configs", str(configs), "--out", str(configs.parent), *words],
        standalone_mode=False, catch_exceptions=False,
    )  # fmt: skip
    assert result.return_value == 0
    return result


def be_commissioned(monkeypatch):
    """Take the rig for one that has passed; how it does is seen in `test_uncommissioned.py`."""
    passed = CommissioningState("0123abcd", "")
    monkeypatch.setattr("rig.commissioning.permission.verdict_of", lambda *_: passed)


def stages(configs):
    found = json.loads(show(configs, "--json").stdout)
    return {stage["what"]: stage["state"] for stage in found["stages"]}, found["next"]


def test_a_fresh_rig_is_commissioned_first(configs, monkeypatch):
    found, following = stages(configs)
    assert following == "rig commission cylinder --on hardware"
    assert found["commissioned"].startswith("no: it was never commissioned")
    be_commissioned(monkeypatch)
    found, following = stages(configs)
    assert found["commissioned"] == "yes, 0123abcd"
    assert following == "rig calibrate cylinder regulators --on hardware"
    found_first = [name for name in PROCEDURES if name != "leak"]
    assert all(found[f"calibrated: {name}"].startswith("no (") for name in found_first)
    assert found["last fault"] == "none is latched"
    assert found["last run on hardware"] == "-"
    assert "crossover" in found["loop of cascade"]
    result = show(configs)
    assert "next: rig calibrate cylinder regulators" in result.stderr


def test_the_first_procedure_that_is_missing_comes_next(configs, monkeypatch):
    be_commissioned(monkeypatch)
    keep(configs, "regulators", "encoders", "wires")
    found, following = stages(configs)
    assert following == "rig calibrate cylinder response --on hardware"
    assert found["calibrated: wires"].startswith(f"{TODAY:%Y-%m-%d}, on hardware, until ")
    assert found["calibrated: response"].startswith("no (")


def test_a_rig_that_is_calibrated_is_tuned(configs, monkeypatch):
    be_commissioned(monkeypatch)
    keep(configs, *PROCEDURES)
    found, following = stages(configs)
    assert following == "rig tune cylinder"
    assert found["tuned"].startswith("no")


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"backend": "sim"}, "on sim"), ({"days": -1}, "expired: ")],
)
def test_what_hardware_does_not_take_comes_again(configs, monkeypatch, changes, words):
    be_commissioned(monkeypatch)
    keep(configs, *PROCEDURES, **changes)
    found, following = stages(configs)
    assert words in found["calibrated: regulators"]
    assert following == "rig calibrate cylinder regulators --on hardware --replace"


def test_what_comes_next_in_simulation_needs_no_hardware(configs, monkeypatch):
    """Whoever has no bus is not sent to the computer and the acceptance test for ever."""

    def following():
        found = show(configs)
        shown = json.loads(show(configs, "--json").stdout)["next_in_simulation"]
        (told,) = [s for s in found.stderr.splitlines() if s.startswith("next in simulation: ")]
        command, _, why = told.removeprefix("next in simulation: ").partition("  (")
        assert command == shown
        assert len(why) > 10  # and why
        return shown

    assert following() == "rig calibrate cylinder --all"
    keep(configs, *(set(PROCEDURES) - {"friction"}), backend="virtual")
    assert following() == "rig calibrate cylinder --all"
    keep(configs, *PROCEDURES, backend="virtual")
    assert following() == "rig tune cylinder"

    folder = configs.parent / "tune-cylinder-cascade-01234567"
    folder.mkdir()
    words = ["--for", "my step", "--seed", "2"]
    kept = keep_attempt(folder, "cascade", 3, ["4 of 27 plants are lost"], words, is_put=False)
    assert following() == "rig tune cylinder --for 'my step' --seed 2 --generations 6"
    assert following() == kept.for_more("cylinder"), "which `rig tune` prints, too"
    state = stages(configs)[0]["tuned"]
    assert "found no better ones: 4 of 27 plants are lost" in state
    assert f"{kept.date:.10} 3 generations for cascade" in state, "the day of that search"

    tuned = {
        "procedure": "tune", "date": TODAY.isoformat(), "operator": "A", "backend": "virtual",
        "conditions": {"tuned for": "cylinder-step"},
    }  # fmt: skip
    store.write(
        configs,
        "cylinder",
        "controllers.cascade",
        {"values": {}, "measured": [], "provenance": tuned},
    )
    assert following() == "rig run EXPERIMENT --rig cylinder"
    state = stages(configs)[0]["tuned: cascade"]
    assert state.startswith(f"{TODAY:%Y-%m-%d}, for cylinder-step: other motions may need others")


def test_what_was_found_before_the_profile_was_changed_comes_again(configs, monkeypatch):
    """The wires of a pair with other bores, then its gains; the encoders do not ask."""
    be_commissioned(monkeypatch)
    keep(configs, *PROCEDURES)
    put_in_force(
        configs, "cylinder", {name: {"cylinder.bore": "16 mm"} for name in ("wires", "leak")}
    )
    put_in_force(configs, "controllers.cascade", {"tune": {"cylinder.bore": "16 mm"}})
    found, following = stages(configs)
    assert following == "rig run EXPERIMENT --on hardware"

    rig = configs / "rigs" / "cylinder.yaml"
    text = rig.read_text(encoding="utf-8").replace("bore: 16 mm", "bore: 25 mm")
    other = text.replace(
        "model: antagonistic-pair", "model: antagonistic-pair\n  cylinder: {bore: 25 mm}"
    )
    rig.write_text(other, encoding="utf-8")
    found, following = stages(configs)
    told = "of another profile: found with cylinder.bore 16 mm, and the profile says 25 mm ("
    assert found["calibrated: wires"].startswith(told)
    assert found["tuned: cascade"].startswith(told)
    assert not any(
        found[f"calibrated: {name}"].startswith("of") for name in ("encoders", "friction")
    )
    assert following == "rig calibrate cylinder wires --on hardware --replace"
    shown = json.loads(show(configs, "--json").stdout)["next_in_simulation"]
    assert shown == "rig calibrate cylinder wires leak --replace"

    put_in_force(configs, "cylinder", {"wires": {"cylinder.bore": "25 mm"}})
    found, following = stages(configs)
    assert following == "rig tune cylinder --controller cascade --replace"
    assert json.loads(show(configs, "--json").stdout)["next_in_simulation"] == following


def put_in_force(configs, target, basis):
    """Write a calibration file again, or anew, with what it rests on."""
    path = configs / "calibration" / "cylinder" / f"{target}.yaml"
    provenance = {"procedure": "tune", "date": TODAY.isoformat(), "operator": "A"}
    empty = {"values": {}, "measured": [], "provenance": {**provenance, "backend": "hardware"}}
    content = store.load(path) if path.exists() else empty
    store.write(
        configs, "cylinder", target,
        {**content, "provenance": {**content["provenance"], "basis": basis}},
    )  # fmt: skip


def test_a_tune_of_another_rig_or_a_damaged_one_is_not_told(configs):
    for name, text in (("tune-cylinder-x-cascade-0", None), ("tune-cylinder-pid-1", "{")):
        folder = configs.parent / name
        folder.mkdir()
        keep_attempt(folder, "cascade", 3, ["lost"], is_put=False)
        if text is not None:
            (folder / "verdict.json").write_text(text)
    assert stages(configs)[0]["tuned"] == "no: the profile's own gains are in force"


def test_what_a_rig_cannot_be_calibrated_for_is_not_missing(configs, monkeypatch):
    be_commissioned(monkeypatch)
    keep(configs, *(name for name in PROCEDURES if name != "leak"))
    found, following = stages(configs)
    assert found["calibrated: leak"].startswith("not on this rig: the air of agonist")
    assert following == "rig tune cylinder"


def test_the_computer_comes_before_the_acceptance_test(configs, monkeypatch):
    missing = Look("bus can0, socketcan can0", "there is no can0", Fitness.NO, "plug it in")
    monkeypatch.setattr("rig.doctor.wiring.look_at_wiring", lambda _: iter([missing]))
    found, following = stages(configs)
    assert found["computer"] == "no: bus can0, socketcan can0: there is no can0"
    assert following == "rig doctor cylinder"


def test_no_advice_skips_what_an_operator_types(configs, monkeypatch):
    for _ in range(2):
        shown = json.loads(show(configs, "--json").stdout)
        assert "--yes" not in json.dumps(shown)
        be_commissioned(monkeypatch)


def test_who_names_no_rig_is_told_which_there_are(configs):
    told = CliRunner().invoke(status, ["--configs", str(configs)])
    assert told.exit_code == 2
    assert "Which RIG? There are: " in told.output
    assert "joint-valves" in told.output


def test_a_latched_fault_comes_before_everything(configs):
    latch = FaultLatch("cylinder")
    latch.set(Path("runs/last"), "the tube is off")
    try:
        found, following = stages(configs)
    finally:
        latch.clear()
    assert found["last fault"].startswith("its last fault is latched: the tube is off (")
    assert following == "rig reset cylinder"


def test_the_last_run_of_each_kind_is_shown(configs):
    for name, backend, started, ending in (
        ("early", "sim", "2026-01-01T00:00:00+00:00", "ok"),
        ("later", "virtual", "2026-01-02T00:00:00+00:00", "faulted"),
        ("real", "hardware", "2026-01-01T12:00:00+00:00", "aborted"),
    ):
        folder = configs.parent / name
        folder.mkdir()
        manifest = {
            "status": ending, "experiment": "cylinder-sine", "backend": backend,
            "started": started, "rig": "cylinder",
        }  # fmt: skip
        (folder / "manifest.json").write_text(json.dumps(manifest))
    found, _ = stages(configs)
    assert found["last simulated run"].startswith("faulted, cylinder-sine, 2026-01-02 00:00:00, ")
    assert found["last run on hardware"].startswith("aborted, cylinder-sine, 2026-01-01 12:00:00")


def test_a_rig_beside_no_folder_of_rigs_is_named_by_its_path(configs, tmp_path):
    (tmp_path / "ours.yaml").write_text("extends: cylinder\ndescription: ours\n")
    found = CliRunner().invoke(status, ["ours.yaml", "--json"], standalone_mode=False)
    assert json.loads(found.stdout)["next"] == "rig commission ours.yaml --on hardware"


def test_a_profile_that_check_refuses_is_not_sent_on(configs):
    own = configs / "rigs" / "short.yaml"
    own.write_text("name: short\nextends: cylinder\ncylinder: {home: 20 mm}\n")
    told = CliRunner().invoke(status, ["short", "--json"])
    assert told.exit_code == 0
    shown = json.loads(told.stdout)
    assert shown["next"] == "rig check short"
    first = shown["stages"][0]
    assert first["what"] == "valid"
    assert "plant.home" in first["state"]
    assert "\n" not in first["state"], "places and excerpts are no lines of a table"
    printed = CliRunner().invoke(status, ["short"])
    assert "next: rig check short  (it is not valid)\n" in printed.stderr


def keep_margins(configs, name, law, started, measured):
    """Keep a run as `rig margins` does, as far as `rig status` reads it."""
    folder = configs.parent / name
    folder.mkdir()
    manifest = {
        "status": "ok", "experiment": "cylinder-margins", "backend": "virtual",
        "started": started, "rig": "cylinder", "law": law,
    }  # fmt: skip
    (folder / "manifest.json").write_text(json.dumps(manifest))
    sensitivity = {"measured": measured, "interval": [0.9 * measured, 1.1 * measured]}
    (folder / "margins.json").write_text(json.dumps({"now": {"sensitivity": sensitivity}}))


def test_what_margins_has_measured_is_told_beside_the_model(configs):
    found, _ = stages(configs)
    assert found["loops measured"].startswith("never: ")
    keep_margins(configs, "early", "cascade", "2026-01-01T00:00:00+00:00", 1.9)
    keep_margins(configs, "later", "cascade", "2026-01-02T00:00:00+00:00", 1.5)
    keep_margins(configs, "other", "pid", "2026-01-03T00:00:00+00:00", 2.5)
    (configs.parent / "other" / "margins.json").write_text("{")
    found, _ = stages(configs)
    told = found["loop of cascade, measured"]
    assert told.startswith("2026-01-02, on virtual, sensitivity 1.5 (95 %: 1.35 to 1.65), ")
    assert told.endswith("later") and "loops measured" not in found
    assert "loop of pid, measured" not in found
    put_in_force(configs, "controllers.cascade", {})
    told = stages(configs)[0]["loop of cascade, measured"]
    assert "other gains were found since: rig margins cylinder --controller cascade" in told


@pytest.mark.parametrize(("share", "lacks"), [("89.0", True), ("99.5", False)])
def test_gains_that_keep_too_little_margin_are_not_said_to_lack_nothing(configs, share, lacks):
    keep(configs, *PROCEDURES, backend="virtual")
    tuned = {
        "procedure": "tune", "date": TODAY.isoformat(), "operator": "A", "backend": "virtual",
        "conditions": {
            "tuned for": "sines and holds", "generations": "8",
            "sensitivity kept": f"{share} % of 200 plants, measured",
        },
    }  # fmt: skip
    content = {"values": {}, "measured": [], "provenance": tuned}
    store.write(configs, "cylinder", "controllers.cascade", content)
    told = show(configs).stderr
    assert "next in simulation: rig run EXPERIMENT --rig cylinder  (nothing " in told
    assert ("(nothing is missing)" in told) is not lacks
    assert ("rig tune cylinder --controller cascade --generations 16)" in told) is lacks
    state = stages(configs)[0]["tuned: cascade"]
    asked = "only 89.0 % of 200 plants keep a sensitivity of at most 1.7 (measured), and 99 % are"
    assert (asked in state) is lacks


def test_a_record_of_simulation_and_of_another_profile_is_told_both(configs, monkeypatch):
    for lack, said in (
        ("on virtual", "no: on virtual, of another profile: this one was changed since"),
        (
            "its profile was changed since it was commissioned",
            "no: its profile was changed since it was commissioned",
        ),
    ):
        verdict = CommissioningState("0123abcd", lack, is_changed=True)
        monkeypatch.setattr("rig.commissioning.permission.verdict_of", lambda *_, v=verdict: v)
        assert stages(configs)[0]["commissioned"] == said


@pytest.mark.parametrize("own", [True, False])
def test_what_comes_next_is_said_after_a_run_of_an_own_rig_and_hides_no_ending(
    configs, tmp_path, monkeypatch, capsys, own
):
    (tmp_path / "mine.yaml").write_text("extends: cylinder\nname: mine\n")
    run = ["run", "cylinder-step", "--on", "sim", "--no-report", "--out", str(tmp_path / "runs")]
    run += ["--rig", str(tmp_path / "mine.yaml")] if own else ["--configs", str(CONFIGS)]
    assert invoke(run) == 0
    assert ("next in simulation: rig calibrate" in capsys.readouterr().err) is own

    def raises(*_, **__):
        raise TypeError("a procedure of others")

    monkeypatch.setattr("rig.cli.status.way", raises)
    assert invoke(run) == 0
