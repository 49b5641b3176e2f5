"""The frames of a start and of a cycle, byte by byte."""

import pytest
from cia401_bench import START, VENTED, Regulators, channel
from scripted_bus import u8, u16, u32

from drivers.cia401.settings import Cia401Settings


@pytest.fixture
def valves():
    bench = Regulators()
    bench.start()
    return bench


def test_the_start_sends_these_frames_in_this_order():
    bench = Regulators()
    bench.driver.connect()
    writes = [f for f in bench.sent() if not f.startswith("601#40")]
    assert writes == [
        "000#8101",  # reset node
        "601#2B17100032000000",  # its heartbeat every 50 ms
        "601#2316100196007F00",  # ours: master 0x7F, 150 ms
        "601#2F43640101000000",  # error mode: take the error value
        "601#2344640100000000",  # which is vented
        "601#2F43640201000000",
        "601#2344640200000000",
        "601#2F066201FF000000",
        "601#2F07620100000000",
        "601#2F29100100000000",  # communication lost: PRE-OPERATIONAL
        "601#23001401010200C0",  # RPDO1 off
        "601#2F00160000000000",
        "601#2300160110011164",
        "601#2300160210021164",
        "601#2300160308010062",
        "601#2F00160003000000",
        "601#2F00140201000000",  # synchronous
        "601#2300140101020040",  # on, at 0x201
        "601#23001801810100C0",
        "601#2F001A0000000000",
        "601#23001A0110010164",
        "601#23001A0210020164",
        "601#23001A0308010060",
        "601#2F001A0003000000",
        "601#2F00180201000000",
        "601#2300180181010040",
        "601#2B11640100000000",  # as ICP DAS's manual writes 0x6411:1, with 0 V
        "601#2B11640200000000",
        "601#2F00620100000000",
    ]
    assert bench.node.objects[0x6444, 1] == bytes(4)


def test_a_setpoint_of_12287_counts_is_the_manuals_frame():
    """``601#2B116401FF2F0000``, the example of ICP DAS's CAN-2024C manual."""
    bench = Regulators()
    bench.driver.connect()
    bench.sent()
    bench.driver._node.write(0x6411, 1, "i16", 0x2FFF)
    assert bench.sent() == ["601#2B116401FF2F0000", "601#4011640100000000"]


def test_a_cycle_sends_setpoints_then_sync_then_heartbeat(valves):
    assert valves.run(VENTED, setpoints=(450e3, 900e3)) == ["201#0040FF7F01", "080#", "77F#05"]
    assert valves.run(VENTED, setpoints=(0.0, 0.0)) == ["201#0000000001", "080#"]


def test_arming_sends_no_heartbeat_and_keeps_the_supply_shut():
    bench = Regulators()
    assert bench.start() == ["000#0101", START, "080#"]


def test_the_heartbeat_comes_every_50_ms_and_stops_with_the_cycle(valves):
    beats = sum("77F#05" in valves.run(VENTED, "701#05") for _ in range(500))
    assert beats == 20
    valves.clock.sleep_until(valves.clock.now() + 1.0)
    assert valves.sent() == []


def test_readings_are_decoded_and_stamped_with_their_sync(valves):
    before = valves.clock.now()
    valves.run(VENTED)
    valves.bus.receive(valves.clock.now())
    valves.interface.put("181#9828100E01")
    valves.bus.receive(valves.clock.now())
    reading = valves.driver.pressure()
    assert reading.value == pytest.approx(((0x2898 - 3000) * 75.0, (0x0E10 - 3000) * 75.0))
    assert reading.t == before
    assert valves.driver.emergency_stop() == (False, before)


def test_four_regulators_and_a_valve_take_two_frames_each_way():
    settings = Cia401Settings(
        node=1,
        channels={name: channel(sub) for sub, name in enumerate("abcd", 1)},
        supply_bit=2,
        stop_bit=0,
    )
    bench = Regulators(settings)
    for sub in (3, 4):
        bench.node.objects |= {
            (0x6411, sub): u16(0),
            (0x6443, sub): u8(0),
            (0x6444, sub): u32(0),
        }
    bench.driver.connect()
    bench.node.sync_answers.append("181#B80BB80BB80BB80B")
    bench.node.sync_answers.append("281#01")
    bench.driver._inputs.arm()
    bench.driver._node.arm()
    bench.bus.synchronise()
    bench.bus.receive(0.0)
    assert not bench.driver._inputs.is_current(), "half a sample is none"
    bench.interface.put("281#01")
    bench.bus.receive(0.0)
    assert bench.driver._inputs.is_current()
    assert bench.driver.pressure().value == (0.0,) * 4
    bench.sent()
    bench.driver._armed = True
    bench.driver.set_pressure((0.0, 0.0, 0.0, 900e3))
    encoded = [pdo.data.hex().upper() for pdo in bench.driver._pdos]
    assert encoded == ["000000000000FF7F", "04"]
