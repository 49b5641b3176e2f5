"""Dead zones and conductances of valves, on made-up recordings whose truth is known."""

import math

import numpy as np
import pytest

from rig.assembly import REGISTRY
from rig.calibration.catalogue import procedures
from rig.calibration.recording import CalibrationRefused, RigLacks, Stretch
from rig.config import find_configs, load_profile

TRUTH = {
    "agonist": (0.021, -0.008, 2.9e-9, 2.4e-9),
    "antagonist": (0.012, -0.026, 3.7e-9, 1.9e-9),
}
ATMOSPHERE, RT = 101_325.0, 287.05 * 293.15


def load(name):
    return load_profile(name, REGISTRY, (), find_configs())


@pytest.fixture(scope="module")
def profile():
    return load("cylinder-valves")


def iso_share(ratio, critical):
    return math.sqrt(1.0 - max((ratio - critical) / (1.0 - critical), 0.0) ** 2)


class Made:
    """Ramps of both chambers, with the openings that valves of `TRUTH` take for them."""

    paths, samples = (), 0

    def __init__(self, profile, *, noise=0.0, share=1.0, sense=1.0):
        rng = np.random.default_rng(3)
        settings = profile.mechanism_settings
        base, x = settings.base_pressure, 0.031
        volume = settings.dead_volume + settings.area * (settings.stroke - x)
        motion = procedures(profile)["valves"].excite(profile, ()).motion
        self.rows = {}
        for segment in motion.segments:
            t = segment.start + 1e-3 * np.arange(280)
            wanted = np.array([motion.pressure_at(min(at, segment.end)) for at in t])
            columns = {"t": t - segment.start}
            rate = np.ptp(wanted) / 0.08
            for channel, (feeds, exhausts, c_in, c_out) in TRUTH.items():
                pressure = base + share * (wanted - base)
                absolute = pressure + ATMOSPHERE
                flow = volume * share * rate / (1.2 * RT)
                if segment.name.startswith("up"):
                    supply = 700e3 + ATMOSPHERE
                    shares = np.array([iso_share(p / supply, 0.3) for p in absolute])
                    opening = feeds + (1.0 - feeds) * flow / (1.185 * supply * shares * c_in)
                else:
                    shares = np.array([iso_share(ATMOSPHERE / p, 0.3) for p in absolute])
                    part = flow / (1.185 * absolute * shares * c_out)
                    opening = exhausts - (1.0 + exhausts) * part
                columns |= {
                    f"applied.{channel}": wanted,
                    f"reading.pressure_{channel}": pressure + noise * rng.standard_normal(len(t)),
                    f"reading.position_{channel}": np.full(len(t), x),
                    f"device.valves_opening_{channel}": sense * opening,
                }
            self.rows[segment.name] = Stretch(columns)

    def require(self, names):
        missing = [name for name in names if name not in self.rows]
        if missing:
            raise CalibrationRefused(f"missing: {missing}")

    def __getitem__(self, name):
        return self.rows[name]


def identified(profile, **made):
    (finding,) = procedures(profile)["valves"].identify(profile, Made(profile, **made), {})
    return finding


def test_what_made_the_ramps_is_found(profile):
    finding = identified(profile)
    assert finding.target == "cylinder"
    for channel, (feeds, exhausts, c_in, c_out) in TRUTH.items():
        found = finding.values["valves"]["channels"][channel]
        assert found["feeds_from"] == pytest.approx(feeds, abs=4e-4)
        assert found["exhausts_from"] == pytest.approx(exhausts, abs=4e-4)
        assert found["conductance_in"] == pytest.approx(c_in, rel=0.01)
        assert found["conductance_out"] == pytest.approx(c_out, rel=0.02)


def test_its_intervals_hold_what_noise_of_the_sensors_makes_of_it(profile):
    finding = identified(profile, noise=100.0)
    clean = {e.name: e.value for e in identified(profile).estimates}
    inside = [e.low <= clean[e.name] <= e.high for e in finding.estimates]
    assert sum(inside) >= len(inside) - 1
    assert all(e.std > 0.0 for e in finding.estimates)


def test_a_pressure_that_does_not_follow_is_refused(profile):
    with pytest.raises(CalibrationRefused, match=r"agonist: the pressure went at .*kPa/s where"):
        identified(profile, share=0.3)


def test_a_valve_that_works_backwards_is_refused(profile):
    with pytest.raises(CalibrationRefused, match=r"agonist.*ports swapped"):
        identified(profile, sense=-1.0)


def test_a_rig_with_regulators_has_no_valves_and_the_other_way_round(profile):
    assert "valves" not in procedures(load("cylinder"))
    for other in ("regulators", "leak"):
        with pytest.raises(RigLacks, match="valves has proportional valves"):
            procedures(profile)[other].excite(profile, ())
