"""Worst-case bus load, against the numbers of the standard's bit counts."""

import re

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


@pytest.mark.parametrize("rate", [500.0, 640.0, 1000.0, 5000.0])
@pytest.mark.parametrize("heartbeat", [0.1, 2e-3])
def test_the_rate_that_is_said_to_fit_fits_and_little_more_does(rate, heartbeat):
    bus = CanBusSettings("virtual", "x", bitrate=125_000, heartbeat=heartbeat, heartbeat_timeout=1)
    rods = [("rod a", Cia406Settings(node=1, stroke=0.1))]
    with pytest.raises(ConfigurationError) as caught:
        check_bus_load("can0", bus, rods, rate)
    said = re.search(
        r"Lower the rate \((\S+) Hz would fit\), map less \(by (\d+) bytes", str(caught.value)
    )
    fits, fewer = float(said[1]), int(said[2])
    assert check_bus_load("can0", bus, rods, fits).total <= bus.max_load
    with pytest.raises(ConfigurationError):
        check_bus_load("can0", bus, rods, fits * 1.1)
    over = compute_bus_load(bus, rods, rate).total - bus.max_load
    assert f"allowed: {100 * over:.1f} % too much" in str(caught.value)
    each = (compute_frame_bits(8) - compute_frame_bits(0)) / 8 * rate / bus.bitrate
    assert (fewer - 1) * each < over <= fewer * each


def test_what_beats_too_often_fits_at_no_rate():
    bus = CanBusSettings("virtual", "x", bitrate=125_000, heartbeat=1e-3, heartbeat_timeout=1)
    with pytest.raises(ConfigurationError, match="no rate would fit"):
        check_bus_load("can0", bus, [("rod", Cia406Settings(node=1, stroke=0.1))], 100.0)
