"""Valves between regulators and chambers: what they keep in, and what a monitor sees."""

import pytest

from drivers.sim.direct.regulators import SimulatedRegulators
from drivers.sim.plants.antagonistic_pair import AntagonisticPairPlant
from drivers.sim.plants.settings import PlantSettings

AGONIST, ANTAGONIST = 0, 1
QUIET = PlantSettings(friction_spread=0.0)


class Clock:
    def now(self):
        return 0.0


def pressurised(leaks=None):
    plant = AntagonisticPairPlant(QUIET, 0)
    if leaks:
        plant.set_leaks(leaks)
    plant.set_supply(True)
    for channel in (AGONIST, ANTAGONIST):
        plant.set_pressure_setpoint(channel, 200e3)
    plant.advance(1.0)
    return plant


def chamber(plant, name="agonist"):
    names = [column for column, _ in plant.truth_columns]
    return plant.truth()[names.index(f"pressure_{name}")]


def monitored(plant, channel=AGONIST):
    shown = []
    for _ in range(200):
        plant.advance(plant.time + 1e-4)
        shown.append(plant.pressure(channel))
    return sum(shown) / len(shown)


def test_a_monitor_sees_its_regulator_and_not_the_locked_chamber():
    plant = pressurised()
    kept = chamber(plant)
    plant.set_lock(AGONIST, True)
    plant.set_pressure_setpoint(AGONIST, 80e3)
    plant.advance(2.0)
    assert monitored(plant) == pytest.approx(80e3, abs=5e3)
    assert chamber(plant) == pytest.approx(kept, rel=0.01)
    plant.set_lock(AGONIST, False)
    plant.advance(plant.time + 1e-3)
    assert plant.pressure(AGONIST) > kept - 15e3
    plant.advance(plant.time + 1.0)
    assert monitored(plant) == pytest.approx(chamber(plant), abs=100.0)
    assert chamber(plant) == pytest.approx(80e3, abs=5e3)


def test_a_chamber_that_was_built_leaky_leaks_on_after_a_repair():
    plant = pressurised((2e-12, 0.0))
    plant.inject("leak", AGONIST)
    plant.inject("repair")
    plant.set_lock(AGONIST, True)
    plant.set_lock(ANTAGONIST, True)
    before, other = chamber(plant), chamber(plant, "antagonist")
    plant.advance(6.0)
    assert 0.85 * before < chamber(plant) < 0.97 * before
    assert chamber(plant, "antagonist") == pytest.approx(other, rel=0.005)


class Port:
    def __init__(self):
        self.locked, self.setpoints = {}, {}

    def set_pressure_setpoint(self, channel, pressure):
        self.setpoints[channel] = pressure

    def pressure(self, channel):
        return self.setpoints[channel]

    def set_supply(self, open):
        pass

    def set_lock(self, channel, locked):
        self.locked[channel] = locked


def regulators(**options):
    port = Port()
    device = SimulatedRegulators("regulators", ("a", "b"), port, Clock(), **options)
    device.connect()
    return device, port


def test_valves_are_shut_on_demand_and_the_safe_state_stays_what_it_is():
    device, port = regulators(safe=("vent", "lock"), lockable=(True, True))
    device.arm()
    device.lock((True, True))
    assert port.locked == {0: True, 1: True}
    device.make_safe()
    assert port.locked == {0: False, 1: True}  # a chamber that is to vent must not stay shut
    device.lock((True, True))
    assert port.locked == {0: False, 1: True}  # not armed


def test_a_channel_without_a_valve_cannot_be_shut():
    device, port = regulators(lockable=(True, False))
    device.arm()
    with pytest.raises(ValueError, match="no valve locks b"):
        device.lock((True, True))
    device.lock((True, False))
    assert port.locked == {0: True}
