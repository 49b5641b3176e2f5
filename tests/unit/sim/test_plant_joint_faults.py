"""What breaks in the joint, and what that does to it."""

import math

import numpy as np
import pytest
from joint_bench import AREA, BASE, CH1, CH2, CH3, CH4, at_base, command, joint, truth

from drivers.sim.plants.pneumatics import ATMOSPHERE


def gauge(plant, channel):
    return float(plant.channels[channel]["pressure"]) - ATMOSPHERE


def air(plant, channel):
    """Return the volume of a chamber and its tube, m³."""
    return 5.9e-6 + AREA * (0.060 - plant.position(channel))


def test_a_cut_wire_lets_the_joint_move_away():
    plant = at_base(joint())
    plant.inject("wire_cut", CH1)
    plant.advance(plant.time + 0.02)
    assert truth(plant)["tension_ch1"] == truth(plant)["ring_tension_ch1"] == 0.0
    assert plant.marker_position()[1] < -0.5e-3
    plant.advance(plant.time + 1.0)
    assert plant.marker_position()[1] < -0.04
    assert plant.position(CH1) == pytest.approx(0.0, abs=1e-3)  # nothing holds the rod
    assert plant.position(CH3) < 5e-3
    assert truth(plant)["tension_ch3"] > 10.0


def test_a_wire_let_go_at_its_rod_is_slack_until_it_is_taken_in():
    plant = at_base(joint())
    before = plant.position(CH1)
    plant.inject("wire_slack", CH1)
    plant.advance(plant.time + 1e-3)
    assert truth(plant)["tension_ch1"] == 0.0
    plant.advance(plant.time + 0.5)
    assert truth(plant)["tension_ch1"] > 10.0
    taken = before - plant.position(CH1) + (before - plant.position(CH3))
    assert taken == pytest.approx(10e-3, rel=0.05)  # half of it by the other side of the ring


def test_an_anchor_that_slips_shows_as_a_length_that_fits_no_pose():
    plant = at_base(joint(slip=2e-3))
    before = np.array([plant.position(k) for k in range(4)])
    plant.inject("anchor_slipped", CH2)
    plant.advance(plant.time + 0.5)
    moved = np.array([plant.position(k) for k in range(4)]) - before
    assert moved[CH2] + moved[CH4] == pytest.approx(-2e-3, rel=0.1)
    assert np.abs(moved[[CH1, CH3]]).max() < 0.1e-3
    plant.inject("anchor_slipped", CH2)
    plant.advance(plant.time + 0.5)
    moved = np.array([plant.position(k) for k in range(4)]) - before
    assert moved[CH2] + moved[CH4] == pytest.approx(-4e-3, rel=0.1)


def test_a_leak_lets_a_locked_chamber_down_and_its_wire_with_it():
    plant = at_base(joint(leak=1e-10))
    for channel in range(4):
        plant.inject("regulator_closed", channel)
    plant.advance(plant.time + 0.1)
    locked = [gauge(plant, k) for k in range(4)]
    plant.advance(plant.time + 1.0)
    assert [gauge(plant, k) for k in range(4)] == pytest.approx(locked, rel=1e-3)
    plant.inject("leak", CH4)
    before, pull = gauge(plant, CH4) + ATMOSPHERE, truth(plant)["tension_ch4"]
    plant.advance(plant.time + 0.3)
    falls = math.exp(-0.3 * 1e-10 * 1.185 * 287.05 * 293.15 / air(plant, CH4))
    assert gauge(plant, CH4) + ATMOSPHERE == pytest.approx(before * falls, rel=0.02)
    assert truth(plant)["tension_ch4"] < pull - 2.0
    plant.advance(plant.time + 2.0)
    assert gauge(plant, CH4) == pytest.approx(0.0, abs=1e3)
    assert plant.marker_position()[0] < -20e-3  # the opposite wire pulls the ring over


@pytest.mark.parametrize("fault", ["regulator_stuck", "regulator_closed", "regulator_open"])
def test_a_regulator_that_fails_leaves_three_that_follow(fault):
    plant = at_base(joint(seals="low-speed"))
    volume, before = air(plant, CH3), gauge(plant, CH3)
    plant.inject(fault, CH3)
    command(plant, [0.05e6] * 4, plant.time + 1.0)
    trapped = (before + ATMOSPHERE) * (volume / air(plant, CH3)) ** 1.2 - ATMOSPHERE
    kept = {"regulator_stuck": BASE, "regulator_closed": trapped, "regulator_open": 0.7e6}[fault]
    assert gauge(plant, CH3) == pytest.approx(kept, abs=3e3)
    assert kept > 0.06e6
    for channel in (CH1, CH2, CH4):
        assert gauge(plant, channel) == pytest.approx(0.05e6, abs=3e3)
    assert plant.marker_position()[1] < -1e-3  # towards the third wire
    plant.inject("repair")
    plant.advance(plant.time + 1.0)
    assert gauge(plant, CH3) == pytest.approx(0.05e6, abs=3e3)


def test_without_supply_all_wires_lose_their_pull():
    plant = at_base(joint())
    plant.inject("supply_lost", 0.03e6)
    plant.advance(plant.time + 1.0)
    for channel in range(4):
        assert gauge(plant, channel) == pytest.approx(0.03e6, abs=2e3)
    plant.inject("supply_lost")
    plant.advance(plant.time + 1.0)
    assert max(truth(plant)[f"tension_ch{k}"] for k in (1, 2, 3, 4)) < 6.0
    plant.inject("repair")
    plant.advance(plant.time + 1.0)
    assert gauge(plant, CH1) == pytest.approx(BASE, abs=3e3)


def test_repair_ties_wires_again():
    plant = at_base(joint())
    free = plant.wire_parameters["free"].copy()
    for fault, channel in (("wire_cut", CH1), ("wire_slack", CH2), ("anchor_slipped", CH3)):
        plant.inject(fault, channel)
    plant.inject("repair")
    assert (plant.wire_parameters["free"] == free).all()
    plant.advance(plant.time + 0.2)
    assert truth(plant)["tension_ch1"] > 10.0


@pytest.mark.parametrize("seed", range(4))
def test_whatever_breaks_the_numbers_stay_numbers(seed):
    """Everything at once, with full pressure: tilts to the stop, slack and jerking wires."""
    rng = np.random.default_rng(seed)
    plant = at_base(joint(seed), 0.2)
    names = [name for name in plant.own_faults if name != "supply_lost"]
    for k in range(40):
        if k % 4 == 0:
            plant.inject(names[rng.integers(len(names))], float(rng.integers(4)))
        command(plant, rng.uniform(0.0, 0.5e6, 4), 0.2 + 0.02 * (k + 1))
        values = truth(plant)
        assert np.isfinite(list(values.values())).all()
        assert (
            min(values[f"{side}tension_ch{n}"] for side in ("", "ring_") for n in (1, 2, 3, 4))
            >= 0.0
        )
        assert all(-2e-3 < plant.position(n) < 62e-3 for n in range(4))
        assert values["axis_z"] > math.cos(math.radians(105.0))
        assert np.linalg.norm(np.array(plant.ring_rotation())) == pytest.approx(math.sqrt(3.0))


@pytest.mark.parametrize(
    ("fault", "value", "message"),
    [
        ("burst", None, "no fault 'burst'; known are regulator_stuck"),
        ("anchor_slipped", 4.0, r"channel's number, 0 \(ch1\), .* 3 \(ch4\); not 4"),
        ("wire_cut", 0.5, "not 0.5"),
        ("supply_lost", -1.0, "-1 Pa"),
    ],
)
def test_a_fault_that_makes_no_sense_is_refused(fault, value, message):
    with pytest.raises(ValueError, match=message):
        joint().inject(fault, value)
