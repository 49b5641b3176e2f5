"""Worst-case bus load, against the numbers of the standard's bit counts."""

import pytest

from drivers.can.load import check_bus_load, compute_bus_load, compute_frame_bits
from drivers.canopen.device_settings import CanopenDeviceSettings
from drivers.canopen.settings import CanBusSettings
from drivers.cia406.settings import Cia406Settings
from rig.hal import ConfigurationError


@pytest.mark.parametrize(("size", "bits"), [(0, 55), (1, 65), (4, 95), (8, 135)])
def test_bits_of_a_frame(size, bits):
    assert compute_frame_bits(size) == bits


class TwoPdos(CanopenDeviceSettings):
    """A node with one full PDO each way."""

    def cyclic_frames(self):
        return (("RPDO", 8), ("TPDO", 8))


@pytest.mark.parametrize(("nodes", "share"), [(2, 0.60), (3, 0.87)])
def test_load_at_one_kilohertz(nodes, share):
    bus = CanBusSettings("virtual", "x", heartbeat=1.0, heartbeat_timeout=3.0)
    load = compute_bus_load(bus, [(f"node {n}", TwoPdos()) for n in range(nodes)], 1000.0)
    assert load.total == pytest.approx(share, abs=0.01)
    assert sum(frame.load for frame in load.frames) == pytest.approx(load.total)


def test_too_much_is_refused_with_what_fills_it():
    bus = CanBusSettings("virtual", "x", bitrate=125_000)
    rods = [("rod a", Cia406Settings(node=1, stroke=0.1))]
    assert check_bus_load("can0", bus, rods, 100.0).total < 0.7
    with pytest.raises(ConfigurationError) as caught:
        check_bus_load("can0", bus, rods, 500.0)
    text = str(caught.value)
    assert "bus can0: the worst-case load at 500 Hz and 125000 bit/s is 7" in text
    assert "at most 70 % is allowed" in text
    assert "rod a TPDO1 position" in text
    assert "SYNC" in text
