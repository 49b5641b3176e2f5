"""Everything that can be wrong with frames while regulators run, and how it is told."""

import errno

import pytest
from cia401_bench import START, VENTED, Regulators

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from drivers.canopen.emergency import decode_emergency
from rig.hal import DeviceFault, LimitExceeded


@pytest.fixture
def valves():
    bench = Regulators()
    bench.start()
    return bench


def test_an_open_stop_contact_is_pressed(valves):
    valves.run(VENTED)
    valves.run("181#B80BB80B00")
    assert valves.driver.emergency_stop().value is True


@pytest.mark.parametrize("bad", ["181#", "181#B80BB80B", "181#B80BB80B0100", "181#B80BB80B010000"])
def test_one_frame_of_wrong_length_is_passed_over_and_five_are_a_fault(valves, bad):
    valves.run(VENTED)
    before = valves.driver.pressure()
    valves.run(bad)
    assert valves.driver.pressure() == before
    valves.run(VENTED)
    assert valves.driver.pressure().t > before.t
    with pytest.raises(DeviceFault, match=r"wrong length.*PDO 0x181.*bound 5 bytes"):
        for _ in range(6):
            valves.run(bad, "701#05")


def test_lost_frames_are_held_then_a_fault(valves):
    valves.run(VENTED)
    for _ in range(4):
        valves.run()
    assert valves.bus.statistics()["held_samples"] == 3
    with pytest.raises(DeviceFault, match=r"does not answer SYNC.*5 missed in a row"):
        valves.run()


def test_a_late_frame_ends_the_gap_and_the_newest_counts(valves):
    valves.run()
    valves.run()
    valves.run("181#B80BB80B01", "181#B80CB80B01")
    assert valves.driver.pressure().value[0] == pytest.approx(0x100 * 75.0)
    valves.run(VENTED)
    assert valves.bus.statistics()["held_samples"] == 0


OTHER = "181#B80CB80B01"
"""A monitor a little higher than the node's own 181#B80BB80B01."""
OWN = "181#B80BB80B01"


def test_two_senders_under_one_identifier_are_a_fault_though_both_seem_right(valves):
    for _ in range(5):  # so many may still be a queue that empties
        valves.run(OWN, OTHER)
    with pytest.raises(DeviceFault, match=r"somebody else sends under its identifier.*PDO 0x181"):
        valves.run(OWN, OTHER)


def test_two_frames_now_and_then_or_the_same_twice_are_no_second_sender(valves):
    for _ in range(10):
        valves.run(OWN, OWN)
    for _ in range(10):  # every other is late
        valves.run()
        valves.run(OTHER, OWN)
    for _ in range(3):  # a queue that empties, then order
        valves.run(OWN, OTHER, OWN)
    valves.run(OWN)
    for _ in range(5):
        valves.run(OTHER, OWN)
    valves.run(OWN)


def test_foreign_remote_and_extended_frames_change_nothing(valves):
    valves.run(VENTED)
    before = valves.driver.pressure()
    valves.interface.put("7E5#0102030405060708")
    valves.interface.put("181#FF7FFF7F00", flags=EXTENDED_FLAG)
    valves.interface.put("181#", flags=REMOTE_FLAG)
    valves.bus.receive(valves.clock.now())
    assert valves.driver.pressure() == before
    assert valves.bus.statistics()["unknown"] == 2
    assert valves.bus.statistics()["remote"] == 1


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ("081#1023020000000000", "EMCY 0x2310 (current at the outputs too high)"),
        ("081#3081110100000000", "heartbeat or node guarding failed"),
        ("081#FFFF81", "EMCY 0xFFFF (device specific)"),
        ("081#00", "EMCY 0xFF00"),
    ],
)
def test_an_emergency_is_a_fault_in_words(valves, frame, words):
    with pytest.raises(DeviceFault) as caught:
        valves.run(VENTED, frame)
    assert words in str(caught.value)
    with pytest.raises(DeviceFault):
        valves.run(VENTED, "081#0000000000000000")


def test_an_emergency_that_says_all_is_well_is_none(valves):
    valves.run(VENTED, "081#0000000000000000")
    assert decode_emergency(bytes(8)).is_reset


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ("701#00", "rebooted while running"),
        ("701#7F", r"left OPERATIONAL.*PRE-OPERATIONAL"),
        ("701#04", r"left OPERATIONAL.*STOPPED"),
    ],
)
def test_a_node_in_another_state_is_a_fault(valves, frame, words):
    with pytest.raises(DeviceFault, match=words):
        valves.run(VENTED, frame)


def test_a_reboot_stays_a_fault_when_the_node_comes_back(valves):
    with pytest.raises(DeviceFault, match="rebooted"):
        valves.run(VENTED, "701#00", "701#05")


def test_a_lost_heartbeat_is_a_fault_although_readings_come(valves):
    with pytest.raises(DeviceFault, match=r"heartbeat is lost.*0\.15"):
        for _ in range(100):
            valves.run(VENTED)


def test_a_broken_monitor_wire_is_named_with_its_signal(valves):
    valves.run(VENTED)
    valves.run("181#B80B000001")
    held = valves.driver.pressure()
    with pytest.raises(DeviceFault, match=r"antagonist has a broken wire.*0x6401:02.*0\.50 V"):
        valves.run("181#B80B000001")
    assert valves.driver.pressure() == held


def test_a_stuck_regulator_is_told_from_one_on_its_way(valves):
    for _ in range(20):  # 40 ms: less than it needs
        valves.run(VENTED, "701#05", setpoints=(300e3, 0.0))
    with pytest.raises(DeviceFault, match=r"pressure of agonist does not follow.*bound 50000 Pa"):
        for _ in range(100):
            valves.run(VENTED, "701#05", setpoints=(300e3, 0.0))


@pytest.mark.parametrize("value", [float("nan"), -1.0, 900.1e3, float("inf")])
def test_a_setpoint_out_of_range_is_refused_and_the_old_one_stays(valves, value):
    valves.run(VENTED, setpoints=(450e3, 0.0))
    with pytest.raises(LimitExceeded, match="valves: setpoint of antagonist"):
        valves.driver.set_pressure((100e3, value))
    valves.interface.put(VENTED)
    valves.bus.transmit(valves.clock.now())
    assert "201#0040000001" in valves.sent()


def test_make_safe_goes_out_at_once_and_latches(valves):
    valves.run(VENTED, setpoints=(450e3, 450e3))
    valves.driver.make_safe()
    valves.driver.set_pressure((450e3, 450e3))
    valves.bus.make_safe()
    assert valves.sent() == [START, "080#"]
    valves.driver.close()
    valves.bus.close()
    valves.bus.close()
    assert valves.sent() == ["000#0200"]
    assert not valves.interface.is_open


def test_a_full_queue_is_tolerated_for_three_cycles(valves):
    valves.interface.refusing = OSError(errno.ENOBUFS, "No buffer space available")
    for _ in range(3):
        valves.run()
    with pytest.raises(DeviceFault, match=r"can0: .*queue is full.*4 cycles refused"):
        for _ in range(2):
            valves.run()
    assert valves.bus.statistics()["refused"] == 4


def test_a_link_that_goes_down_is_a_fault(valves):
    valves.interface.failing = OSError(errno.ENETDOWN, "Network is down")
    with pytest.raises(DeviceFault, match="can0: the interface went down"):
        valves.run()


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ("040#0000000000000000", "bus-off"),
        ("100#0000000000000000", "restarted after bus-off"),
        ("004#0010000000000000", "error passive"),
        ("004#0020000000000000", "error passive"),
    ],
)
def test_error_frames_are_faults_of_the_bus(valves, frame, words):
    valves.interface.put(frame, flags=ERROR_FLAG)
    with pytest.raises(DeviceFault, match=f"can0: .*{words}"):
        valves.run(VENTED)


def test_an_error_warning_is_only_counted(valves):
    valves.interface.put("004#0004000000000000", flags=ERROR_FLAG)
    valves.run(VENTED)
    assert valves.bus.statistics()["error_frames"] == 1
