"""Two buses of a profile that are one wire are found where everybody is asked."""

import dataclasses
import random

import pytest

from rig.assembly import REGISTRY, Backend, build_rig
from rig.assembly.survey import survey_buses, survey_rig
from rig.commissioning.operator import SimulatedOperator
from rig.commissioning.session import CommissioningFacts, begin, commission, steps_of
from rig.commissioning.site import Site
from rig.config import find_configs, load_profile
from rig.hal import DeviceFault, FastCanBus


class Bridged(FastCanBus):
    """An interface on a wire that it shares with others, of which some frames are lost."""

    def __init__(self, bus, wire, chance, lost):
        self.bus, self.wire, self.inbox = bus, wire, []
        self.chance, self.lost = chance, lost
        wire.append(self)

    def tell(self, frame):
        for other in self.wire:
            if other is not self and self.chance.random() >= self.lost:
                other.inbox.append(frame)

    def send_data(self, can_id, data):
        for end in self.wire:
            end.bus.send_data(can_id, data)
        self.tell((can_id, data))

    def drain(self, limit):
        frames = self.bus.drain(limit)
        for frame in frames:
            self.tell(frame)
        waiting, self.inbox = self.inbox, []
        return frames + waiting

    def shutdown(self):
        self.wire.remove(self)
        self.bus.shutdown()


def bridged(profile, lost=0.0):
    """Return a rig of which all buses are one wire."""
    rig, wire, chance = build_rig(profile, Backend.VIRTUAL), [], random.Random(0)
    for bus in rig.buses.values():
        opened = bus.open_interface
        bus.open_interface = lambda opened=opened: Bridged(opened(), wire, chance, lost)
    return rig


def profile_of(rig, *said):
    return load_profile(rig, REGISTRY, said, find_configs(None))


@pytest.mark.parametrize("lost", [0.0, 0.2])
@pytest.mark.parametrize("rig", ["joint", "legs-can"])
def test_the_bus_step_refuses_two_buses_that_are_one_wire(rig, lost, tmp_path):
    profile = profile_of(rig)
    site = Site(profile, lambda its: bridged(its, lost), SimulatedOperator(), tmp_path)
    record = begin(profile, [tmp_path], CommissioningFacts("virtual"), anew=True)
    stopped = commission(site, record, steps_of(profile)[:1], tmp_path, lambda said: None)
    assert stopped is not None
    assert stopped.startswith("bus: bus can1: it is one wire with the bus can0")


def test_devices_that_are_expected_on_either_do_not_hide_it():
    """One number on both wires is nobody that the profile does not know."""
    profile = profile_of("joint", "devices.encoder-2.node=0x21")
    with pytest.raises(DeviceFault, match="one wire"):
        survey_rig(bridged(profile))


@pytest.mark.parametrize("rig", ["joint", "legs-can"])
def test_buses_of_their_own_hear_nothing_of_one_another(rig):
    answers = survey_rig(build_rig(profile_of(rig), Backend.VIRTUAL))
    assert answers
    assert not any(answer.differences for answer in answers)


def test_real_interfaces_on_one_wire_are_told(monkeypatch):
    profile = profile_of("joint")
    on = {"interface": "virtual", "channel": "one", "options": {}}
    buses = {
        name: dataclasses.replace(entry, settings=dataclasses.replace(entry.settings, **on))
        for name, entry in profile.buses.items()
    }
    monkeypatch.setattr("drivers.can.interfaces.interface_trouble", lambda *_: None)
    with pytest.raises(DeviceFault, match="can1: it is one wire with the bus can0"):
        survey_buses(dataclasses.replace(profile, buses=buses), {})
