"""What was measured does not hold for a profile that was changed in what it rests on."""

from datetime import UTC, date, datetime

import numpy as np
import pytest

from rig.assembly import REGISTRY, Backend
from rig.calibration import store
from rig.calibration.basis import basis_of, basis_of_gains
from rig.calibration.procedure import Finding
from rig.calibration.recording import Recording
from rig.config import dump_resolved, find_configs, load_profile
from rig.config.basis import by_procedure, changes_of
from rig.config.calibration_state import calibration_states
from rig.experiment.permission import check_permitted
from rig.hal import DeviceError

BORE = ("cylinder.bore=32 mm", "plant.cylinder.bore=32 mm")
TODAY = date(2026, 11, 22)


@pytest.fixture
def configs(tmp_path, monkeypatch):
    source = find_configs()[-1] / "rigs" / "cylinder.yaml"
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    (tmp_path / "configs" / "rigs" / "cylinder.yaml").write_text(source.read_text("utf-8"))
    monkeypatch.chdir(tmp_path)  # a name is found here
    return tmp_path / "configs"


def load(configs, *options):
    return load_profile("cylinder", REGISTRY, options, [configs])


def calibrate(configs, procedure, values, *options, target="cylinder", basis=True):
    profile = load(configs, *options)
    found = Finding(target, values, (), np.ones(4), "N", 2.0, 4, ())
    now = datetime(2026, 11, 21, tzinfo=UTC)
    said = store.Circumstances("me", 1e6, {}, now, "hardware", None)
    old = store.in_force(profile, [configs], target)
    if old is not None:  # as a procedure's estimates would be
        old["measured"].append({"name": "x", "procedure": old["provenance"]["procedure"]})
    rests = basis_of(profile, target, with_dimensions=False) if basis else None
    content = store.compose(found, procedure, profile, Recording([]), said, old, (), rests)
    content["measured"][:] = []
    content["provenance"]["samples"] = 4
    return store.write(configs, "cylinder", target, content)


def state(configs, *options, on_hardware=True):
    return calibration_states(load(configs, *options), TODAY, on_hardware=on_hardware)


def test_a_calibration_holds_until_the_bore_is_another(configs):
    calibrate(configs, "wires", {"home": "30.1 mm"})
    (held,) = state(configs)
    assert held.problems == ()
    (changed,) = state(configs, *BORE)
    assert changed.sentence == (
        "its calibration was found with cylinder.bore 16 mm, and the profile says 32 mm; mend it "
        "with: rig calibrate cylinder wires --replace --on hardware"
    )


def test_hardware_is_refused_and_a_simulation_is_told(configs):
    calibrate(configs, "wires", {"home": "30.1 mm"})

    class Plan:
        profile = load(configs, *BORE)

    with pytest.raises(DeviceError, match=r"found with cylinder\.bore 16 mm"):
        check_permitted(Plan, Backend.HARDWARE)
    (doubt,) = check_permitted(Plan, Backend.SIM)
    assert doubt.startswith("cylinder: its calibration was found with cylinder.bore 16 mm")


def test_a_procedure_that_is_done_again_answers_for_itself_alone(configs):
    calibrate(configs, "wires", {"home": "30.1 mm"})
    path = calibrate(configs, "friction", {"friction": {"coulomb": "9.1 N"}}, *BORE)
    kept = by_procedure(store.load(path)["provenance"]["basis"])
    assert {name: its["cylinder.bore"] for name, its in kept.items()} == {
        "wires": "16 mm", "friction": "32 mm",
    }  # fmt: skip
    (now,) = state(configs, *BORE)
    assert now.remedy == "rig calibrate cylinder wires --replace --on hardware"
    (before,) = state(configs)
    assert before.remedy == "rig calibrate cylinder friction --replace --on hardware"


def test_procedures_of_one_profile_keep_it_once(configs):
    calibrate(configs, "wires", {"home": "30.1 mm"})
    path = calibrate(configs, "friction", {"friction": {"coulomb": "9.1 N"}})
    assert list(store.load(path)["provenance"]["basis"]) == ["wires, friction"]
    (now,) = state(configs, *BORE)
    assert now.remedy == "rig calibrate cylinder wires friction --replace --on hardware"


@pytest.mark.parametrize(
    "option",
    [
        "cylinder.home=29 mm",  # of a command line: it is in force
        "cylinder.limits.following=5 mm",
        "cylinder.base_pressure=100 kPa",
        "devices.encoder-agonist.node=0x30",
        "devices.regulators.channels.agonist.safe=vent",
        "loop.rate=500 Hz",
    ],
)
def test_what_it_does_not_rest_on_may_change(configs, option):
    calibrate(configs, "wires", {"home": "30.1 mm"})
    assert all(not of.problems for of in state(configs, option))


@pytest.mark.parametrize(
    ("option", "was", "now"),
    [
        ("cylinder.home=29 mm", "cylinder.home 30 mm", "29 mm"),
        ("devices.encoder-agonist.step=5 um", "devices.encoder-agonist.step none", "5 µm"),
        (
            "devices.regulators.channels.agonist.monitor.pressure=[0 kPa, 900 kPa]",
            "devices.regulators.channels.agonist.monitor.pressure 0 kPa, 500 kPa",
            "0 kPa, 900 kPa",
        ),
    ],
)
def test_what_it_rests_on_is_named(configs, option, was, now):
    calibrate(configs, "friction", {"friction": {"coulomb": "9.1 N"}})
    (found,) = state(configs, option)
    assert found.problems == (f"was found with {was}, and the profile says {now}",)


def write(configs, before, after):
    path = configs / "rigs" / "cylinder.yaml"
    text = path.read_text("utf-8")
    assert before in text
    path.write_text(text.replace(before, after))


def problems(configs):
    return {its.name: its.problems for its in state(configs, on_hardware=False)}


def test_who_writes_another_value_where_one_was_found_is_told(configs):
    """It means another part, and is not in force; who copies what was found changes nothing."""
    calibrate(configs, "wires", {"home": "30.1 mm"})
    write(configs, "home: 30 mm", "home: 30.1 mm")
    assert problems(configs) == {"cylinder": ()}
    write(configs, "home: 30.1 mm", "home: 29 mm")
    assert problems(configs) == {
        "cylinder": ("was found with cylinder.home 30 mm, and the profile says 29 mm",)
    }


def test_each_answers_for_what_it_has_found_itself(configs):
    said = {"channels": {"agonist": {"setpoint": {"pressure": ["1 kPa", "502 kPa"]}}}}
    calibrate(configs, "regulators", said, target="regulators")
    calibrate(configs, "friction", {"friction": {"coulomb": "9.1 N"}})
    write(configs, "pressure: [0 kPa, 500 kPa]", "pressure: [0 kPa, 900 kPa]")
    found = problems(configs)
    assert "devices.regulators.channels.agonist.setpoint.pressure" in found["regulators"][0]
    assert ".agonist.setpoint.pressure" not in found["cylinder"][0]


def test_a_device_rests_on_its_own_readings_alone(configs):
    calibrate(configs, "encoders", {"scale": 1.002}, target="encoder-agonist")
    assert all(not of.problems for of in state(configs, *BORE))
    assert all(not of.problems for of in state(configs, "devices.encoder-antagonist.step=5 um"))
    (found,) = state(configs, "devices.encoder-agonist.reversed=true")
    assert "devices.encoder-agonist.reversed false" in found.sentence


def test_a_file_of_before_it_was_kept_still_holds(configs):
    path = calibrate(configs, "wires", {"home": "30.1 mm"}, basis=False)
    assert store.load(path)["provenance"]["basis"] == {}
    (found,) = state(configs, *BORE)
    assert found.problems == ()


def test_a_resolved_profile_knows_it_too(configs, tmp_path):
    calibrate(configs, "wires", {"home": "30.1 mm"})
    path = tmp_path / "again.yaml"
    path.write_text(dump_resolved(load(configs)), encoding="utf-8")
    again = load_profile(path, REGISTRY, (), [configs])
    assert again == load(configs)
    assert changes_of(again.calibration, again) == {}
    other = load_profile(path, REGISTRY, BORE, [configs])
    assert list(changes_of(other.calibration, other)) == ["wires"]


def test_gains_rest_on_what_the_law_was_told_of_the_rig(configs):
    provenance = {
        "procedure": "tune", "date": "2026-11-21", "operator": "me", "backend": "profile",
        "basis": {"tune": basis_of_gains(load(configs))},
    }  # fmt: skip
    content = {"values": {"position_rate": 100.0}, "provenance": provenance}
    store.write(configs, "cylinder", "controllers.cascade", content, "tune")
    (held,) = state(configs)
    assert held.problems == ()
    (changed,) = state(configs, *BORE)
    assert changed.sentence == (
        "its calibration has gains that were found with cylinder.bore 16 mm, and the profile says "
        "32 mm; mend it with: rig tune cylinder --controller cascade --replace"
    )
    for option in ("loop.rate=500 Hz", "cylinder.friction.coulomb=8 N"):
        (changed,) = state(configs, option)
        assert option.partition("=")[0] in changed.sentence
    # What a calibration has found is in force, whatever the file says beside it.
    calibrate(configs, "friction", {"friction": {"coulomb": "9.1 N"}})
    assert all(not of.problems for of in state(configs, "cylinder.friction.coulomb=8 N"))
