"""Identification from made-up recordings: what is true is known, and bad input is told."""

import dataclasses

import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.estimates import fit, interval, mean_of
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import find_configs, load_profile
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.runtime.log import Log


@pytest.fixture(scope="module")
def profile():
    return load_profile("cylinder", REGISTRY, (), find_configs())


def recording(stretches, end=None):
    """Make a recording of stretches of 100 rows each, from columns by stretch."""
    rows = 100
    names = list(next(iter(stretches.values())))
    columns = ("phase", "reference.time", *names, "truth.secret")
    segments = [Segment(name, float(k), k + 1.0) for k, name in enumerate(stretches)]
    t = np.arange(len(stretches) * rows) / rows
    values = [
        np.broadcast_to(
            np.concatenate([np.full(rows, s[name]) for s in stretches.values()]), len(t)
        )
        for name in names
    ]
    table = np.column_stack([np.ones_like(t), t, *values, np.full_like(t, 42.0)])
    keep = slice(None) if end is None else t < end
    log = Log(
        tuple(Column(name, "", "") for name in columns),
        np.arange(len(t), dtype=np.uint64)[keep], t[keep], table[keep],
        np.zeros(len(t), np.uint64)[keep], True,
    )  # fmt: skip
    return Recording([(log, segments)])


def test_the_truth_of_a_simulation_is_not_in_a_recording():
    found = recording({"a": {"reading.x": 1.0}})
    assert "truth.secret" not in found["a"]
    with pytest.raises(CalibrationRefused, match="no column"):
        found["a"]["truth.secret"]


def test_a_stretch_that_was_cut_short_is_missing():
    found = recording({name: {"reading.x": 1.0} for name in "abc"}, end=1.5)
    assert found.names == ("a",)
    with pytest.raises(CalibrationRefused, match="2 of 3 stretches are missing or cut short: b, c"):
        found.require("abc")


class TestRegulators:
    OFFSET, GAIN, BOW, LOOP = 2e3, 0.98, 0.006, 3.5e3
    MONITOR_OFFSET, MONITOR_GAIN = 1.5e3, 1.01

    def made(self, profile, noise=0.0, top=np.inf):
        procedure = procedures(profile)["regulators"]
        motion = procedure.excite(profile, ()).motion
        rng = np.random.default_rng(3)
        stretches, gauge = {}, {}
        for segment in motion.segments:
            c = motion.pressure_at(segment.end - 0.01)
            side = 1.0 if " up " in segment.name else -1.0
            s = self.OFFSET + self.GAIN * c - 0.5 * side * self.LOOP
            p = min(s + 4.0 * self.BOW * s * (1.0 - s / 500e3), top)
            shown = self.MONITOR_OFFSET + self.MONITOR_GAIN * p
            stretches[segment.name] = {
                "applied.agonist": c, "applied.antagonist": c,
                "reading.pressure_agonist": shown, "reading.pressure_antagonist": shown,
            }  # fmt: skip
            gauge[segment.name] = p + noise * rng.standard_normal()
        readings = {"gauge agonist": gauge, "gauge antagonist": gauge}
        return procedure, recording(stretches), readings

    def test_finds_what_was_put_in(self, profile):
        procedure, found, readings = self.made(profile, noise=1.0)
        (finding,) = procedure.identify(profile, found, readings)
        values = {e.name: e.value for e in finding.estimates}
        assert values["agonist.setpoint.offset"] == pytest.approx(self.OFFSET, abs=5.0)
        assert values["agonist.setpoint.gain"] == pytest.approx(self.GAIN, abs=1e-5)
        assert values["agonist.setpoint.linearity"] == pytest.approx(self.BOW, abs=2e-5)
        assert values["agonist.setpoint.hysteresis"] == pytest.approx(self.LOOP, abs=5.0)
        assert values["agonist.monitor.gain"] == pytest.approx(1.0 / self.MONITOR_GAIN, abs=1e-5)
        low, high = (
            float(text.split()[0])
            for text in finding.values["channels"]["agonist"]["monitor"]["pressure"]
        )
        assert low == pytest.approx(-self.MONITOR_OFFSET / self.MONITOR_GAIN, abs=5.0)
        assert high - low == pytest.approx(500e3 / self.MONITOR_GAIN, abs=10.0)

    def test_tells_a_saturated_regulator(self, profile):
        procedure, found, readings = self.made(profile, top=330e3)
        with pytest.raises(CalibrationRefused, match=r"agonist: above .* saturated"):
            procedure.identify(profile, found, readings)

    def test_tells_one_that_does_not_follow(self, profile):
        procedure, found, readings = self.made(profile, top=50e3)
        with pytest.raises(CalibrationRefused, match="too little to tell a gain"):
            procedure.identify(profile, found, readings)

    def test_tells_which_reading_is_missing(self, profile):
        procedure, found, readings = self.made(profile)
        del readings["gauge antagonist"]["sweep 2 up 3"]
        with pytest.raises(CalibrationRefused, match=r"not read in 1 of 36 .*'sweep 2 up 3'"):
            procedure.identify(profile, found, readings)

    def test_goes_on_with_the_sweep_that_is_not_whole(self, profile):
        procedure = procedures(profile)["regulators"]
        names = [segment.name for segment in procedure.excite(profile, ()).motion.segments]
        rest = procedure.excite(profile, names[:20]).motion
        assert [segment.name for segment in rest.segments] == names[18:]
        assert procedure.excite(profile, names).motion.segments == ()


class TestEncoders:
    def made(self, profile, scale=1.002, offset=1.5e-3, frozen=False, travel=1.0, sign=1.0):
        procedure = procedures(profile)["encoders"]
        names = [s.name for s in procedure.excite(profile, ()).motion.segments]
        rng = np.random.default_rng(5)
        stretches, calipers = {}, {"caliper agonist": {}, "caliper antagonist": {}}
        for k, name in enumerate(names):
            x = 30e-3 + travel * 15e-3 * np.sin(0.9 * k)
            counted = 30e-3 if frozen else sign * (x - offset) / scale
            stretches[name] = {
                "reading.position_agonist": counted, "reading.position_antagonist": x,
            }  # fmt: skip
            for caliper in calipers.values():
                caliper[name] = x + 1e-6 * rng.standard_normal()
        return procedure, recording(stretches), calipers

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_finds_zero_scale_and_direction(self, profile, sign):
        procedure, found, readings = self.made(profile, sign=sign)
        finding, other = procedure.identify(profile, found, readings)
        (panel,) = finding.panels
        drawn = panel.residual_scale * (panel.y - panel.fit)
        assert drawn == pytest.approx(1e6 * finding.residuals)  # as its label says, µm
        assert finding.target == "encoder-agonist"
        assert finding.values["reversed"] is (sign < 0)
        assert finding.values["scale"] == pytest.approx(1.002, abs=1e-4)
        assert float(finding.values["offset"].split()[0]) == pytest.approx(1.5e-3, abs=3e-6)
        assert other.values["scale"] == pytest.approx(1.0, abs=1e-4)

    def test_tells_a_frozen_encoder(self, profile):
        with pytest.raises(CalibrationRefused, match=r"encoder-agonist: .* it is frozen"):
            self._identify(profile, frozen=True)

    def test_tells_a_stuck_rod(self, profile):
        with pytest.raises(CalibrationRefused, match=r"the rod moved by .* is it stuck"):
            self._identify(profile, travel=0.1)

    def _identify(self, profile, **how):
        procedure, found, readings = self.made(profile, **how)
        procedure.identify(profile, found, readings)


def test_intervals_hold_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(11)
    held = 0
    for _ in range(400):
        x = np.linspace(-1.0, 1.0, 12)
        y = 0.3 + 2.0 * x + 0.1 * rng.standard_normal(12)
        estimate = fit(lambda q: y - q[0] - q[1] * x, (0.0, 1.0), (1.0, 1.0)).parameter(1, "b", "1")  # noqa: B023
        held += estimate.low <= 2.0 <= estimate.high
    assert 0.92 <= held / 400 <= 0.98


def test_blocks_that_err_together_widen_the_interval():
    rng = np.random.default_rng(7)
    held = 0
    for _ in range(200):
        groups = np.repeat(np.arange(10), 50)
        y = 1.0 + 0.1 * rng.standard_normal(10)[groups] + 0.01 * rng.standard_normal(500)
        estimate = fit(lambda q: y - q[0], (0.0,), (1.0,), groups=groups).parameter(0, "m", "1")  # noqa: B023
        held += estimate.low <= 1.0 <= estimate.high
    assert 0.91 <= held / 200 <= 0.99


def test_refuses_what_the_data_do_not_say():
    with pytest.raises(ValueError, match="do not determine"):
        fit(lambda q: np.ones(5) - q[0] - q[1], (0.0, 0.0), (1.0, 1.0))
    with pytest.raises(ValueError, match="one repetition"):
        mean_of("x", "m", [1.0])
    assert interval("x", 1.0, "m", 0.1, 1e9).high == pytest.approx(1.196, abs=1e-3)


def test_every_procedure_keeps_the_limits_but_those_that_it_names():
    profile = load_profile("cylinder-locked", REGISTRY, (), find_configs())
    for procedure in procedures(profile).values():
        excitation = procedure.excite(profile, ())
        usual, now = (p.mechanism_settings.limits for p in (profile, excitation.profile))
        changed = {
            field.name
            for field in dataclasses.fields(usual)
            if getattr(usual, field.name) != getattr(now, field.name)
        }
        assert all(any(f"limits.{name}" in note for note in excitation.notes) for name in changed)
        named = [note.split()[0] for note in excitation.notes]
        assert sorted(named) == sorted(
            [*(f"limits.{name}" for name in changed), "alarms.pressure.slow"]
        )
