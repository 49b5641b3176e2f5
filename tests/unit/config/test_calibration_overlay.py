"""Calibration files, laid over a profile's devices."""

import pytest

from rig.config import ProfileError, dump_resolved


def messages(configs, *overrides):
    with pytest.raises(ProfileError) as caught:
        configs.profile("bench", *overrides)
    return str(caught.value)


def test_values_are_laid_over_and_their_origin_kept(configs):
    configs.calibrate()
    encoder = configs.profile().devices["encoder"]
    assert encoder.settings.offset == 0.12e-3
    assert encoder.settings.resolution == 0.9995e-6
    assert encoder.settings.stroke == 60e-3
    assert encoder.calibration.file == "calibration/bench/encoder.yaml"
    provenance = encoder.calibration.provenance
    assert (provenance.date, provenance.serial, provenance.samples) == ("2026-11-21", 4711, 400)
    assert (provenance.residual_rms, provenance.residual_max, provenance.unit) == (3e-6, 9e-6, "m")
    assert [path.name for path in configs.profile().files] == ["bench.yaml", "encoder.yaml"]


def test_options_win_over_calibration_and_can_switch_it_off(configs):
    configs.calibrate()
    assert (
        configs.profile("bench", "devices.encoder.offset=1 mm").devices["encoder"].settings.offset
        == 1e-3
    )
    without = configs.profile("bench", "devices.encoder.calibration=false").devices["encoder"]
    assert (without.settings.offset, without.calibration) == (0.0, None)


def test_a_whole_profile_goes_without_its_devices_calibrations_too(configs):
    configs.calibrate()
    without = configs.profile("bench", "calibration=false").devices["encoder"]
    assert (without.settings.offset, without.calibration) == (0.0, None)
    but_one = ("calibration=false", "devices.encoder.calibration=true")
    assert configs.profile("bench", *but_one).devices["encoder"].settings.offset == 0.12e-3


def test_a_resolved_profile_is_not_calibrated_twice(configs):
    configs.calibrate()
    profile = configs.profile()
    configs.write("rigs/again.yaml", dump_resolved(profile))
    configs.calibrate("0.12 mm", "5 mm")
    assert configs.profile("again") == profile


def test_how_well_a_device_was_measured_stays_with_it(configs):
    measured = "measured:\n- {name: offset, value: 1.2e-4, unit: m, std: 3e-6}\nprovenance:"
    configs.calibrate("provenance:", measured)
    profile = configs.profile()
    assert profile.devices["encoder"].calibration.deviations == {"offset": 3e-6}
    configs.write("rigs/again.yaml", dump_resolved(profile))
    assert configs.profile("again") == profile


def test_errors_in_values_point_at_the_calibration_file(configs):
    configs.calibrate("offset: 0.12 mm", "offset: 3 N\n  ofset: 1")
    text = messages(configs)
    assert "encoder.yaml:2:11: offset: '3 N' is not in m" in text
    assert "encoder.yaml:3:3: unknown key 'ofset'" in text


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("  operator: A. N. Other\n", "", "key 'operator' is missing"),
        ("2026-11-21", "yesterday", "expected a date as in 2026-11-21"),
        ("offset", "node: 3\n  driver", "driver is not a value of a calibration"),
        ("residual_max: 9 µm", "residual_max: 9 ms", "residual_max is in s, but the unit is 'm'"),
        ("values", "vaules", "did you mean values?"),
        ("samples: 400", "samples: 0", "samples is 0, expected at least 1"),
        ("samples: 400", "smaples: 4", "did you mean samples?"),
    ],
)
def test_strict(configs, old, new, expected):
    configs.calibrate(old, new)
    assert expected in messages(configs)
