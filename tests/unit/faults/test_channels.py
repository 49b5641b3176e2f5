"""Faults that take a channel's number say which channel it is."""

from functools import partial

import pytest

from rig.assembly import REGISTRY, check_channels
from rig.assembly.channels import channels_of
from rig.config import find_configs, load_profile
from rig.config.simulation_models import FaultSpec
from rig.experiment.injected import faults_that_came, faults_that_never_came
from rig.faults.catalogue import KINDS
from rig.faults.world_kinds import _channels
from rig.hal import ConfigurationError
from rig.hal.world import BY_CHANNEL


def broken(rig, *faults):
    text = ", ".join(f"{{at: 1 s, {fault}}}" for fault in faults)
    return load_profile(rig, REGISTRY, [f"simulation.faults=[{text}]"], find_configs())


def test_every_kind_that_takes_a_number_is_known():
    kinds = {
        kind.apply.args[0]
        for kind in KINDS.values()
        if isinstance(kind.places, partial) and kind.places.func is _channels
    }
    assert kinds == BY_CHANNEL - {"leak"}  # whose number a plant takes, though no kind gives it


@pytest.mark.parametrize(
    ("fault", "channel"),
    [
        (FaultSpec(1.0, "plant", "wire_cut", 2.0), "ch3"),
        (FaultSpec(1.0, "plant", "wire_cut"), "ch1"),
        (FaultSpec(1.0, "regulators", "wire_break", 3.0), "ch4"),
        (FaultSpec(1.0, "plant", "supply_lost", 2.0), None),
        (FaultSpec(1.0, "plant", "ch1.leak", 2.0), None),
        (FaultSpec(1.0, "can0", "bus_off"), None),
    ],
)
def test_the_event_of_a_fault_names_its_channel(fault, channel):
    channels = channels_of(broken("joint"))
    [(t, sentence, data)] = faults_that_came([fault], channels, 0.25, 10.0)
    assert t == 0.75
    assert data.get("channel") == channel
    assert ("count from 0" in sentence) is (channel is not None)
    assert channel is None or f", {channel} (value " in sentence
    assert data["magnitude"] == fault.size


@pytest.mark.parametrize(("at", "never"), [(10.25, False), (10.26, True)])
def test_a_fault_that_comes_after_the_end_is_told(at, never):
    faults = [FaultSpec(at, "plant", "wire_cut"), FaultSpec(1.0, "can0", "bus_off")]
    told = list(faults_that_never_came(faults, 0.25, 10.0))
    came = list(faults_that_came(faults, {}, 0.25, 10.0))
    assert len(told) == never
    assert len(told) + len(came) == 2
    if never:
        assert "wire_cut of plant never came" in told[0]
        assert "stood at 10.2 s" in told[0]


def test_a_number_that_is_no_channel_is_refused_with_the_names():
    check_channels(broken("cylinder", "device: plant, fault: wire_cut, value: 1"))
    check_channels(broken("cylinder", "device: plant, fault: supply_lost, value: 7 kPa"))
    with pytest.raises(ConfigurationError, match=r"0 \(agonist\), 1 \(antagonist\); not 2"):
        check_channels(broken("cylinder", "device: plant, fault: wire_cut, value: 2"))
    with pytest.raises(ConfigurationError, match=r"wire_break .* not 0\.5"):
        check_channels(broken("joint", "device: regulators, fault: wire_break, value: 0.5"))
