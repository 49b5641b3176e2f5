"""Calibration files: sealed, kept, compared, used; and whether they hold."""

from datetime import UTC, date, datetime

import numpy as np
import pytest

from rig.assembly import REGISTRY, Backend
from rig.calibration import store
from rig.calibration.estimates import Estimate
from rig.calibration.procedure import Finding
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import ProfileError, dump_resolved, find_configs, load_profile
from rig.config.calibration_state import calibration_states

SERIAL = "devices.encoder-agonist.serial=7"


@pytest.fixture
def configs(tmp_path):
    source = find_configs()[-1] / "rigs" / "cylinder.yaml"
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs" / "cylinder.yaml").write_text(source.read_text(encoding="utf-8"))
    return tmp_path


def load(configs, *options):
    return load_profile("cylinder", REGISTRY, options, [configs])


def finding(offset=1.5e-3, rms=10e-6, target="encoder-agonist"):
    estimate = Estimate("offset", offset, "m", 2e-6, offset - 4e-6, offset + 4e-6)
    residuals = rms * np.array([1.0, -1.0] * 6)
    values = {"offset": f"{offset} m", "scale": 1.002}
    return Finding(target, values, (estimate,), residuals, "m", 50e-6, 12, ())


def calibrate(configs, when="2026-11-21", days=365, **how):
    profile = load(configs, SERIAL)
    found = finding(**how)
    now = datetime.fromisoformat(when).replace(tzinfo=UTC)
    said = store.Circumstances(
        "A. N. Other", days * 86_400.0, {"temperature": "23 degC"}, now, "hardware", None
    )
    old = store.in_force(profile, [configs], found.target)
    store.check_not_worse(found, "encoders", old)
    content = store.compose(found, "encoders", profile, Recording([]), said, old)
    content["provenance"]["samples"] = 12
    return store.write(configs, "cylinder", found.target, content)


def test_the_values_are_used_and_what_they_replaced_is_kept(configs):
    calibrate(configs)
    entry = load(configs).devices["encoder-agonist"]
    assert (entry.settings.offset, entry.settings.scale) == (1.5e-3, 1.002)
    assert (entry.nominal.offset, entry.nominal.scale) == (0.0, 1.0)
    provenance = entry.calibration.provenance
    assert (provenance.operator, provenance.serial, provenance.procedure) == (
        "A. N. Other", 7, "encoders",
    )  # fmt: skip
    assert provenance.residual_bound == 50e-6
    assert provenance.conditions == {"temperature": "23 degC"}


def test_a_mechanism_is_calibrated_like_a_device(configs):
    found = Finding("cylinder", {"friction": {"coulomb": "9.1 N"}}, (), np.ones(4), "N", 2.0, 4, ())
    said = store.Circumstances("me", 1e6, {}, datetime.now(UTC), "hardware", None)
    content = store.compose(found, "friction", load(configs), Recording([]), said, None)
    content["provenance"]["samples"] = 4
    store.write(configs, "cylinder", "cylinder", content)
    profile = load(configs)
    assert profile.mechanism_settings.friction.coulomb == 9.1
    assert profile.nominal_settings.friction.coulomb == 9.5
    assert profile.mechanism_settings.friction.viscous == 50.0
    assert load(configs, "calibration=false").mechanism_settings.friction.coulomb == 9.5


def test_a_resolved_profile_still_knows_what_was_before(configs, tmp_path):
    calibrate(configs)
    profile = load(configs)
    path = tmp_path / "again.yaml"
    path.write_text(dump_resolved(profile), encoding="utf-8")
    again = load_profile(path, REGISTRY, (), [configs])
    assert again == profile
    assert again.devices["encoder-agonist"].nominal.offset == 0.0


def test_a_value_changed_by_hand_is_refused_with_its_place(configs):
    path = calibrate(configs)
    path.write_text(path.read_text().replace("0.0015 m", "0.0016 m"), encoding="utf-8")
    with pytest.raises(ProfileError, match=r"encoder-agonist.yaml:3:16: the file was changed") as e:
        load(configs)
    assert "it was: offset: 0.0015 m" in str(e.value)


def test_a_changed_file_without_its_history_is_refused_at_its_seal(configs):
    path = calibrate(configs)
    for kept in (path.parent / "history").rglob("*.yaml"):
        kept.unlink()
    path.write_text(path.read_text().replace("0.0015 m", "0.0016 m"), encoding="utf-8")
    with pytest.raises(ProfileError, match=r"encoder-agonist.yaml:\d+:1: the file was changed"):
        load(configs)


def test_a_file_that_was_changed_along_with_its_history_is_refused(configs):
    path = calibrate(configs)
    for file in (path, *(path.parent / "history").rglob("*.yaml")):
        file.write_text(file.read_text().replace("0.0015 m", "0.0016 m"), encoding="utf-8")
    with pytest.raises(ProfileError, match=r"encoder-agonist.yaml:\d+:1: the file was changed"):
        load(configs)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 0.99])
def test_a_truncated_file_is_refused_with_its_place(configs, share):
    path = calibrate(configs)
    text = path.read_text()
    path.write_text(text[: int(share * len(text))], encoding="utf-8")
    with pytest.raises(ProfileError, match=r"encoder-agonist.yaml:\d+:\d+: the file "):
        load(configs)


def test_the_older_file_is_kept_and_named_as_parent(configs):
    calibrate(configs, "2026-11-21", offset=1.5e-3)
    path = calibrate(configs, "2027-03-01", offset=1.6e-3)
    kept = store.history([configs], "cylinder", "encoder-agonist")
    assert len(kept) == 2
    assert store.load(kept[0])["values"]["offset"] == "0.0015 m"
    parent = store.load(path)["provenance"]["parent"]
    assert store.find([configs], "cylinder", parent.removeprefix("history/")[:-5]) == kept[0]


def test_a_worse_fit_does_not_replace_a_better_one(configs):
    path = calibrate(configs, rms=10e-6)
    before = path.read_text()
    with pytest.raises(CalibrationRefused, match="--replace"):
        calibrate(configs, "2026-12-01", rms=20e-6)
    assert path.read_text() == before
    calibrate(configs, "2026-12-01", rms=11e-6)  # chance explains that much


def test_a_fit_that_does_not_describe_the_device_is_refused(configs):
    with pytest.raises(CalibrationRefused, match="above the bound of 5e-05 m"):
        calibrate(configs, rms=60e-6)


def states(configs, *options, today=date(2026, 12, 1)):
    return [state.sentence for state in calibration_states(load(configs, *options), today)
            if state.problems]  # fmt: skip


def test_what_does_not_hold_is_told_with_what_would_mend_it(configs):
    calibrate(configs)
    assert states(configs) == []
    (wrong,) = states(configs, "devices.encoder-agonist.serial=8")
    assert "is of serial number 7, the profile's device has 8" in wrong
    rig = configs / "rigs" / "cylinder.yaml"
    assert f"rig calibrate {rig} encoders --replace --on hardware" in wrong
    (old,) = states(configs, today=date(2028, 1, 1))
    assert "expired on 2027-11-21" in old


def test_hardware_is_refused_and_a_simulation_warned(configs):
    from rig.calibration.catalogue import procedures
    from rig.calibration.session import plan_of
    from rig.experiment.permission import check_permitted
    from rig.hal import DeviceError

    calibrate(configs)
    profile = load(configs, "devices.encoder-agonist.serial=8")
    procedure = procedures(profile)["response"]
    plan = plan_of(procedure, procedure.excite(profile, ()))
    (warning,) = check_permitted(plan, Backend.SIM)
    assert warning.startswith("encoder-agonist: its calibration is of serial number 7")
    with pytest.raises(DeviceError, match="mend it with: rig calibrate"):
        check_permitted(plan, Backend.HARDWARE)


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_the_simulated_rig_does_not_change_when_it_is_calibrated(configs, backend):
    """A calibration is the driver's knowledge: the emulated encoder still counts as it did."""
    calibrate(configs)
    raw = reading(load(configs, "devices.encoder-agonist.calibration=false"), backend)
    assert raw == pytest.approx(30e-3, abs=5e-6)
    assert reading(load(configs), backend) == pytest.approx(1.002 * raw + 1.5e-3, abs=5e-6)


def reading(profile, backend):
    from rig.assembly import build_rig

    with build_rig(profile, backend) as rig:
        rig.arm()
        now = rig.clock.now()
        for bus in rig.buses.values():
            bus.receive(now)
        return rig.devices["encoder-agonist"].position().value[0]


def test_values_of_another_procedure_stay(configs):
    calibrate(configs)
    profile = load(configs)
    found = Finding(
        "encoder-agonist", {"overtravel": "3 mm"}, (), np.full(4, 1e-6), "m", 1e-3, 4, ()
    )
    said = store.Circumstances("me", 1e6, {}, datetime.now(UTC), "hardware", None)
    old = store.in_force(profile, [configs], "encoder-agonist")
    store.check_not_worse(found, "jig", old)
    content = store.compose(found, "jig", profile, Recording([]), said, old)
    assert content["values"] == {"offset": "0.0015 m", "scale": 1.002, "overtravel": "3 mm"}
    assert [m["procedure"] for m in content["measured"]] == ["encoders"]
