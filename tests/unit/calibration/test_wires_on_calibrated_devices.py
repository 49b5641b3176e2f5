"""Wires whose encoders and monitors were calibrated, and are off by what that left open."""

from dataclasses import replace

import numpy as np
import pytest
from pneumatic_rigs import pneumatics_of, shown_by
from test_pneumatic_calibration import TestWires as MadeWires

from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.config import find_configs, load_profile
from rig.config.models import Calibration, Provenance
from rig.mechanisms.pneumatic.calibration.rod_readings import rod_errors

DRAWN = 24
CALIPER, LEVELS = 10e-6, 15
SCALE, OFFSET, GAIN = 3.6e-4, 150.0, 6e-4
ZERO = CALIPER / np.sqrt(LEVELS)


@pytest.fixture(scope="module", params=["cylinder", "joint"])
def profile(request):
    return load_profile(request.param, REGISTRY, (), find_configs())


def calibrated(profile, scattered=CALIPER):
    """Return a profile whose devices carry what their calibrations said of themselves."""
    pneumatics = pneumatics_of(profile)
    of_line = np.sqrt(1.0 - 2.0 / LEVELS)  # two of its degrees of freedom are the line's
    known = Provenance("2026-11-29", "test", residual_rms=scattered * of_line, blocks=LEVELS)
    encoder = Calibration("encoder.yaml", known, deviations={"scale": SCALE})
    monitors = {}
    for channel in pneumatics.channels:
        monitors |= {f"{channel}.monitor.offset": OFFSET, f"{channel}.monitor.gain": GAIN}
    regulators = Calibration("regulators.yaml", known, deviations=monitors)
    devices = dict(profile.devices)
    for name in pneumatics.encoders:
        devices[name] = replace(devices[name], calibration=encoder)
    devices[pneumatics.regulators] = replace(devices[pneumatics.regulators], calibration=regulators)
    return replace(profile, devices=devices)


def shown_wrong(profile, rows, rng):
    """Return what devices show that are off by as much as their calibrations leave open."""
    pneumatics, home = pneumatics_of(profile), profile.mechanism_settings.home
    wrong = {name: dict(row) for name, row in rows.items()}
    for k, channel in enumerate(pneumatics.channels):
        zero, scale = ZERO * rng.standard_normal(), SCALE * rng.standard_normal()
        offset, gain = OFFSET * rng.standard_normal(), GAIN * rng.standard_normal()
        column, _ = shown_by(profile, k, 0.0)
        _, at_home = shown_by(profile, k, home)
        for row in wrong.values():
            row[column] += zero + scale * (row[column] - at_home)
            pressure = f"reading.pressure_{channel}"
            row[pressure] += offset + gain * row[pressure]
    return wrong


def test_intervals_hold_what_calibrated_devices_are_off_by(profile):
    of, rng = MadeWires(), np.random.default_rng(61)
    wires = procedures(profile)["wires"]
    recording = of.recording(profile)
    true = {"home": of.HOME, "wire.stiffness": of.STIFFNESS}
    right = recording._rows
    told = {key: dict.fromkeys(true, 0) for key in ("alike", "scattered alone")}
    for _ in range(DRAWN):
        recording._rows = shown_wrong(profile, right, rng)
        for key, rig in (("alike", calibrated(profile)), ("scattered alone", profile)):
            (finding,) = wires.identify(rig, recording, {})
            for e in finding.estimates:
                if e.name in true:
                    told[key][e.name] += e.low <= true[e.name] <= e.high
    assert all(count >= 0.8 * DRAWN for count in told["alike"].values()), told
    assert all(count <= 0.7 * DRAWN for count in told["scattered alone"].values()), told


def test_the_error_of_an_encoder_is_what_its_caliper_left(profile):
    rods = rod_errors(calibrated(profile), pneumatics_of(profile))
    assert [rod.zero for rod in rods] == [(pytest.approx(ZERO), LEVELS - 2.0)] * len(rods)
    untold = rod_errors(profile, pneumatics_of(profile))
    assert all(rod.zero[0] == rod.scale == rod.offset == rod.gain == 0.0 for rod in untold)
