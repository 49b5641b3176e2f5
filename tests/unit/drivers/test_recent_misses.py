"""Whether one device is silent, or its bus loses frames of all."""

from types import SimpleNamespace

from drivers.canopen.misses import RecentMisses


def missing(*devices_of_cycles):
    syncs = SimpleNamespace(count=0)
    misses = RecentMisses(syncs)
    for devices in devices_of_cycles:
        syncs.count += 1
        for device in devices:
            misses.note(device)
            misses.note(device)  # asked twice in a cycle it has missed once
    return misses


def test_a_device_alone_is_silent():
    misses = missing(*5 * [["valves"]])
    assert misses.of_others("valves") == ""


def test_others_that_miss_as_well_are_counted():
    misses = missing(["valves", "rod"], ["valves"], ["valves", "rod", "cell"])
    said = misses.of_others("valves")
    assert "frames of others are lost on this bus" in said
    assert said.endswith("2 of rod")  # one frame is lost now and then
    assert misses.of_others("rod").endswith("3 of valves")


def test_what_is_long_ago_is_forgotten():
    misses = missing(*5 * [["rod"]], *47 * [[]], *5 * [["valves"]])
    assert misses.of_others("valves") == ""
