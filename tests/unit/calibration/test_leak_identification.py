"""Leaks of chambers, on made-up recordings whose truth is known."""

import math

import numpy as np
import pytest
from pneumatic_rigs import pneumatics_of, shown_by

from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.preview import preview
from rig.calibration.recording import CalibrationRefused, RigLacks, Stretch
from rig.config import find_configs, load_profile
from rig.mechanisms.pneumatic.calibration.lock_cycles import LockScript

ATMOSPHERE, REFERENCE = 101_325.0, 1.185 * 287.05 * 293.15
TUBE, EXHAUST = 7e-6, 2e-9


@pytest.fixture(scope="module", params=["cylinder", "joint"])
def profile(request):
    return load_profile(f"{request.param}-locked", REGISTRY, (), find_configs())


class Made:
    """Chambers that were locked, leaked, and let out by wide-open exhausts."""

    paths, samples = (), 0

    def __init__(self, profile, leaks, *, noise=0.0, slips=(), delay=0.004, blind=False):
        rng = np.random.default_rng(5)
        pneumatics, settings = pneumatics_of(profile), profile.mechanism_settings
        motion = procedures(profile)["leak"].excite(profile, ()).motion
        starts = {s.name: s.start for s in motion.segments}
        self.rows = {}
        for name in dict.fromkeys(s.name.rsplit(" ", 1)[0] for s in motion.segments):
            wait = starts[f"{name} opened"] - starts[f"{name} before"] - 0.3
            looks = {look: {} for look in ("before", "shut", "opened")}
            times = {look: starts[f"{name} {look}"] + 1e-3 * np.arange(60) for look in looks}
            for k, (channel, leak) in enumerate(zip(pneumatics.channels, leaks, strict=True)):
                side = (1.0 if name.startswith("in") else -1.0) * (-1.0) ** k
                x = settings.home - 15e-3 * side
                volume = TUBE + settings.area * (settings.stroke - x)
                had, behind = 330e3 + ATMOSPHERE, 210e3 + ATMOSPHERE
                left = had * math.exp(-leak * REFERENCE / volume * wait)
                s = np.maximum(times["opened"] - times["opened"][0] - delay, 0.0)
                out = np.maximum(left * np.exp(-EXHAUST * REFERENCE / volume * s), behind)
                seen = {
                    "before": np.full(60, had),
                    "shut": np.full(60, behind),
                    "opened": np.where((s > 0.0) & (not blind), out, behind),
                }
                for look, pressure in seen.items():
                    shown = pressure - ATMOSPHERE + noise * rng.standard_normal(60)
                    slipped = 1e-3 if name in slips and look != "before" else 0.0
                    column, rod = shown_by(profile, k, x + slipped)
                    looks[look][f"reading.pressure_{channel}"] = shown
                    looks[look][column] = np.full(60, rod)
            for look, columns in looks.items():
                self.rows[f"{name} {look}"] = Stretch({**columns, "t": times[look]})

    def require(self, names):
        missing = [name for name in names if name not in self.rows]
        if missing:
            raise CalibrationRefused(f"missing: {missing}")

    def __getitem__(self, name):
        return self.rows[name]


def found_in(profile, recording):
    (finding,) = procedures(profile)["leak"].identify(profile, recording, {})
    return finding, {e.name: e for e in finding.estimates}


def leaks_of(profile, scale=1e-12):
    return [scale * (1.0 + 0.5 * k) for k in range(len(pneumatics_of(profile).channels))]


def test_a_leak_is_found_whatever_the_tube_and_the_exhaust(profile):
    leaks = leaks_of(profile)
    _, found = found_in(profile, Made(profile, leaks, noise=100.0))
    for channel, leak in zip(pneumatics_of(profile).channels, leaks, strict=True):
        estimate = found[f"leak.{channel}.conductance"]
        assert estimate.value == pytest.approx(leak, abs=4.0 * estimate.std)
        assert estimate.std < 0.05 * leak
        assert estimate.high - estimate.value > estimate.value - estimate.low


def test_of_a_tight_chamber_it_says_how_tight(profile):
    finding, found = found_in(profile, Made(profile, leaks_of(profile, 1e-18), noise=200.0))
    assert not [name for name in found if name.endswith("conductance")]
    assert len(finding.notes) == len(pneumatics_of(profile).channels)
    assert all("loses at most 0.0" in note for note in finding.notes)
    for channel in pneumatics_of(profile).channels:
        rate = found[f"leak.{channel}.rate"]
        assert abs(rate.value) < 4.0 * rate.std < 2e-4


def test_waits_in_which_a_rod_slipped_are_left_out_and_too_many_refused(profile):
    leaks = leaks_of(profile)
    _, found = found_in(profile, Made(profile, leaks, noise=50.0, slips=("in 2", "out 5")))
    first = pneumatics_of(profile).channels[0]
    assert found[f"leak.{first}.conductance"].low < leaks[0]
    many = tuple(f"in {k}" for k in range(1, 6))
    with pytest.raises(CalibrationRefused, match="its rod slipped in 5 of 8 waits"):
        found_in(profile, Made(profile, leaks, slips=many))


def test_a_tube_that_is_off_and_a_valve_that_does_not_open_are_told_apart(profile):
    with pytest.raises(CalibrationRefused, match="is its tube off"):
        found_in(profile, Made(profile, leaks_of(profile, 2e-11)))
    with pytest.raises(CalibrationRefused, match="does it open"):
        found_in(profile, Made(profile, leaks_of(profile), blind=True))


def test_a_rig_without_valves_is_told_what_it_lacks_before_anything_moves():
    profile = load_profile("cylinder", REGISTRY, (), find_configs())
    with pytest.raises(RigLacks, match=r"valve .* at the cylinder.*agonist\.lock_bit"):
        procedures(profile)["leak"].excite(profile, ())


def test_what_is_done_is_not_done_again_and_the_preview_says_what_is_locked(profile):
    procedure = procedures(profile)["leak"]
    whole = procedure.excite(profile, ()).motion
    done = [s.name for s in whole.segments if s.name.startswith("in")]
    rest = procedure.excite(profile, done).motion
    assert {s.name for s in rest.segments} == {s.name for s in whole.segments} - set(done)
    assert procedure.excite(profile, [s.name for s in whole.segments]).motion.segments == ()
    told = "\n".join(preview(procedure, profile, procedure.excite(profile, ())))
    assert "locked in 16 times" in told
    assert "friction does" in told


class Valves:
    lockable = (True, True)

    def __init__(self):
        self.calls = []

    def lock(self, shut):
        self.calls.append(shut)


def test_valves_are_shut_for_as_long_as_planned_and_open_in_between():
    profile = load_profile("cylinder-locked", REGISTRY, (), find_configs())
    motion = procedures(profile)["leak"].excite(profile, ()).motion
    assert isinstance(motion, LockScript)
    valves = Valves()
    motion.attach({"regulators": valves})
    from controllers.cylinder.types import PairState

    state, seen, shut = PairState(0.0, 16e-3, 120e3, 120e3), [], False
    motion.reset(state)
    for t in np.arange(0.0, motion.duration, 0.05):
        command = motion.update(state, motion.at(float(t)))
        shut = valves.calls[-1][0] if valves.calls else False
        if shut:
            seen.append(command)
    assert valves.calls == [(True, True), (False, False)] * 16
    assert not shut
    assert len(seen) == pytest.approx(2 * 17.2 / 0.05, abs=32)
    assert {tuple(command) for command in seen} == {(220e3, 220e3)}
