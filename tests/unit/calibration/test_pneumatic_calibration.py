"""Wires, leaning motions and uneven blocks, on made-up data whose truth is known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pneumatic_rigs import pneumatics_of, shown_by

from controllers.spherical_joint.wires import InverseKinematics
from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.estimates import fit, middle_of
from rig.calibration.recording import CalibrationRefused, Stretch
from rig.config import find_configs, load_profile
from rig.mechanisms.joint.calibration.leaning import Leaning, Strokes


@pytest.fixture(scope="module", params=["cylinder", "joint"])
def profile(request):
    return load_profile(request.param, REGISTRY, (), find_configs())


class Made:
    """A recording of stretches that stand still."""

    paths, samples = (), 0

    def __init__(self, rows):
        self._rows = rows

    def require(self, names):
        missing = [name for name in names if name not in self._rows]
        if missing:
            raise CalibrationRefused(f"missing: {missing}")

    def __getitem__(self, name):
        return Stretch({key: np.full(4, value) for key, value in self._rows[name].items()})


class TestWires:
    HOME, STIFFNESS, DRY, GROWTH, SOFT = 29.1e-3, 70e3, 5.0, 0.03, 7e-6

    def recording(self, profile, give=1.0):
        """Pull and let go with friction that follows the rods' way after Dahl."""
        pneumatics, settings = pneumatics_of(profile), profile.mechanism_settings
        motion = procedures(profile)["wires"].excite(profile, ()).motion
        ends = {round(s.end, 6): s.name for s in motion.segments}
        friction, before, x_before, rows = 0.0, 0.0, self.HOME, {}
        for t in np.arange(0.0, motion.duration + 0.01, 0.01):
            pull = settings.area * motion.pressure_at(t)
            # The rod's way and its friction depend on each other: solved together.
            limit = self.DRY + self.GROWTH * pull
            side = math.copysign(1.0, pull - before)
            stiff = (1.0 - side * friction / limit) / self.SOFT
            way = (pull - before) / (self.STIFFNESS + stiff)
            friction += stiff * way
            x_before, before = x_before - way, pull
            name = ends.get(round(float(t), 6))
            if name:
                x = self.HOME - give * (self.HOME - x_before)
                count = range(len(pneumatics.channels))
                rows[name] = dict(shown_by(profile, k, x) for k in count) | {
                    f"reading.pressure_{c}": pull / settings.area for c in pneumatics.channels
                }
        return Made(rows)

    def test_finds_home_and_stiffness_whatever_the_bristles(self, profile):
        (finding,) = procedures(profile)["wires"].identify(profile, self.recording(profile), {})
        (panel,) = finding.panels
        drawn = panel.residual_scale * (panel.y - panel.fit)
        assert drawn == pytest.approx(1e6 * finding.residuals)  # as its label says, µm
        found = {e.name: e.value for e in finding.estimates}
        assert found["home"] == pytest.approx(self.HOME, abs=0.5e-6)
        assert found["wire.stiffness"] == pytest.approx(self.STIFFNESS, rel=2e-3)
        # A joint's controller makes up for how its wires give.
        written = {"cylinder": None, "joint": f"{found['wire.stiffness']:.9g} N/m"}
        assert finding.values.get("wire_stiffness") == written[profile.mechanism]

    def test_says_where_whole_sweeps_err_together(self, profile):
        for drift, told in ((0.0, 0), (2e-6, 1)):
            recording, rng = self.recording(profile), np.random.default_rng(1)
            for name, row in recording._rows.items():
                error = 0.2e-6 * rng.standard_normal() + drift * name.startswith("sweep 2")
                for k in range(len(pneumatics_of(profile).channels)):
                    row[shown_by(profile, k, 0.0)[0]] += error
            (finding,) = procedures(profile)["wires"].identify(profile, recording, {})
            assert sum("err together" in note for note in finding.notes) == told

    def test_finds_each_wire_by_how_the_ring_stands(self, profile):
        """The first rod is 0.8 mm off and the ring leans by 1 deg towards its anchor."""
        if profile.mechanism == "cylinder":
            assert procedures(profile)["wires"].instruments(profile) == ()
            return
        recording, lean, off = self.recording(profile), math.radians(1.0), (0.8e-3, 0.0, 0.0, 0.0)
        inverse = InverseKinematics(profile.mechanism_settings.geometry)
        pulled = inverse.shortening((math.sin(lean), 0.0, math.cos(lean)))
        for row in recording._rows.values():
            for k, channel in enumerate(("ch1", "ch2", "ch3", "ch4")):
                row[f"reading.rod_{channel}"] += pulled[k] - off[k]
        instruments = procedures(profile)["wires"].instruments(profile)
        readings = {
            i.name: dict.fromkeys(i.stretches, lean if i.name.endswith("x") else 0.0)
            for i in instruments
        }
        (finding,) = procedures(profile)["wires"].identify(profile, recording, readings)
        found = {e.name: e.value for e in finding.estimates}
        # The drawing's tolerances make more of the intervals the more the ring leans.
        home = finding.estimates[0]
        assert 2e-6 < home.high - home.value < 10e-6
        for k, each in enumerate(off):
            assert found[f"home.ch{k + 1}"] == pytest.approx(self.HOME + each, abs=5e-6)
        offsets = [float(text.split()[0]) for text in finding.values["wire_offsets"]]
        assert offsets == pytest.approx([0.6e-3, -0.2e-3, -0.2e-3, -0.2e-3], abs=5e-6)
        assert not finding.notes

        del readings["inclinometer y"]["sweep 2 up 1"]
        with pytest.raises(CalibrationRefused, match="along y was not read in 1 of 12"):
            procedures(profile)["wires"].identify(profile, recording, readings)
        readings["inclinometer x"]["sweep 1 up 1"] = 0.3
        readings["inclinometer y"]["sweep 2 up 1"] = 0.0
        with pytest.raises(CalibrationRefused, match="put it upright"):
            procedures(profile)["wires"].identify(profile, recording, readings)

    def test_of_single_wires_it_says_nothing_without_an_inclinometer(self, profile):
        (finding,) = procedures(profile)["wires"].identify(profile, self.recording(profile), {})
        assert "wire_offsets" not in finding.values
        assert len(finding.notes) == (profile.mechanism == "joint")

    def test_tells_rods_that_do_not_give(self, profile):
        with pytest.raises(CalibrationRefused, match="too little to tell where the wires are"):
            procedures(profile)["wires"].identify(profile, self.recording(profile, 0.01), {})

    def test_tells_a_reversed_encoder(self, profile):
        with pytest.raises(CalibrationRefused, match="an encoder is reversed"):
            procedures(profile)["wires"].identify(profile, self.recording(profile, -1.0), {})


def test_a_ring_leans_as_far_as_its_wires_are_to_go():
    strokes = Strokes(8e-3, (0.03,))
    leaning = Leaning(strokes, 0.7, 25e-3, ((0.2, 1.5e5),))
    h = 1e-4
    for t in (0.0, 0.1, 0.3, 0.41, 0.7):
        here, before, after = leaning.at(t), leaning.at(t - h), leaning.at(t + h)
        assert math.dist((0, 0, 0), here.axis) == pytest.approx(1.0)
        assert math.acos(here.axis[2]) == pytest.approx(abs(strokes.at(t).position) / 25e-3)
        for now, rate, rise, a, b in zip(
            here.axis, here.velocity, here.acceleration, before.axis, after.axis, strict=True
        ):
            assert rate == pytest.approx((b - a) / (2 * h), abs=1e-3)
            assert rise == pytest.approx((b - 2 * now + a) / h**2, abs=0.5)
        assert here.base_pressure == (1.5e5 if t >= 0.2 else None)


def test_an_uneven_design_has_honest_intervals():
    """Two of eight blocks decide the slope: as many degrees of freedom as that leaves it."""
    rng = np.random.default_rng(3)
    groups = np.repeat(np.arange(8), 6)
    x = np.where(groups < 2, 1.0, 0.0) * np.sign(groups - 0.5) + 0.05 * rng.standard_normal(48)
    held = []
    for _ in range(300):
        y = 2.0 + 3.0 * x + 0.1 * rng.standard_normal(48)
        found = fit(lambda q: y - q[0] - q[1] * x, (0.0, 0.0), (1.0, 1.0), groups=groups)  # noqa: B023
        slope = found.parameter(1, "slope", "1")
        held.append(slope.low <= 3.0 <= slope.high)
    assert found.freedom_of((0.0, 1.0)) < 4.0 < found.freedom_of((1.0, 0.0))
    assert 0.92 <= np.mean(held) <= 0.985


def test_the_middle_of_unlike_groups_has_honest_intervals():
    """One direction makes up all of the scatter: as many degrees of freedom as it has."""
    rng = np.random.default_rng(2)
    held = [
        e.low <= 2.0 <= e.high
        for _ in range(600)
        for up, down in [(3.0 + rng.standard_normal(5), 1.0 + 0.05 * rng.standard_normal(5))]
        for e in [middle_of("x", "s", up.tolist(), down.tolist())]
    ]
    assert 0.93 <= np.mean(held) <= 0.975
    alike = middle_of("x", "s", [1.0, 1.0], [2.0, 2.0])
    assert (alike.value, alike.low, alike.high) == (1.5, 1.5, 1.5)


def test_only_limits_that_rest_on_what_is_looked_for_are_wider(profile):
    wider, notes = pneumatics_of(profile).with_wider_limits(3e-3)
    usual, now = (p.mechanism_settings.limits for p in (profile, wider))
    is_pair = profile.mechanism == "cylinder"
    names = ["mismatch", "following"] if is_pair else ["residual", "disagreement", "following"]
    told = [*(f"limits.{name}" for name in names), "alarms.pressure.slow"]
    if profile.mechanism == "joint":
        told += ["alarms.oscillation.amplitude"]
        told += ["camera.max_absence", "camera.marker.area_tolerance"]
    assert [note.split()[0] for note in notes] == told
    (before, slow) = (p.mechanism_settings.alarms.pressure for p in (profile, wider))
    assert slow == replace(before, slow=2.0)
    for field in type(usual).__dataclass_fields__:
        if field != "run_off":
            assert (getattr(usual, field) == getattr(now, field)) is (field not in names)
    # A ring may stray, and not run off; a pair that glides by itself follows nothing.
    assert (now.most_run_off == usual.most_run_off) is not is_pair
    assert pneumatics_of(profile).reach(0.6) < 15e-3
