"""The frames of a start, a cycle and an end, byte by byte, and every way they can be wrong."""

import errno
from dataclasses import replace

import pytest
from scripted_bus import Bench, ScriptedNode, common_objects, u8, u16, u32

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from drivers.canopen.emergency import decode_emergency
from drivers.cia401.channel_settings import MonitorSignal, RegulatorChannel, SetpointSignal
from drivers.cia401.device import Cia401Regulators
from drivers.cia401.settings import Cia401Settings, FollowingSettings
from drivers.cia406.device import Cia406Encoder
from drivers.cia406.settings import Cia406Settings
from rig.hal import ConfigurationError, ConnectionFailed, DeviceFault, LimitExceeded


def channel(sub):
    return RegulatorChannel(
        SetpointSignal(sub=sub, voltage=(0.0, 10.0), pressure=(0.0, 900e3)),
        MonitorSignal(sub=sub, raw=(3000.0, 15000.0), voltage=(1.0, 5.0), pressure=(0.0, 900e3)),
    )


SETTINGS = Cia401Settings(
    node=1,
    channels={"agonist": channel(1), "antagonist": channel(2)},
    supply_bit=0,
    stop_bit=0,
    following=FollowingSettings(deviation=50e3, time=0.1, response=0.05),
)
VENTED = "181#B80BB80B01"  # both monitors 3000 counts (0 Pa), the stop's contact closed
START = "201#0000000000"


class Regulators(Bench):
    def __init__(self, settings=SETTINGS, **options):
        super().__init__(**options)
        objects = common_objects(0x000F0191) | {
            (0x6206, 1): u8(0),
            (0x6207, 1): u8(0xFF),
            (0x6200, 1): u8(0),
        }
        for sub in (1, 2):
            objects |= {
                (0x6411, sub): u16(0x2FFF),
                (0x6443, sub): u8(0),
                (0x6444, sub): u32(0x7FFF),
            }
        self.node = ScriptedNode(self.interface, 1, objects)
        self.driver = Cia401Regulators("valves", settings, self.bus)

    def start(self, reading=VENTED):
        self.driver.connect()
        self.sent()
        self.node.sync_answers.append(reading)
        self.driver.arm()
        return self.sent()

    def run(self, *frames, setpoints=(0.0, 0.0)):
        self.interface.put(*frames)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        self.driver.set_pressure(setpoints)
        self.bus.transmit(now)
        self.clock.sleep_until(now + 0.002)
        return self.sent()


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


def with_deadline():
    bench = Regulators(replace(SETTINGS, setpoint_deadline=0.006))
    bench.node.objects[0x1400, 5] = u16(0)
    return bench


def test_the_deadline_of_setpoints_is_set_and_starts_with_the_first_of_them():
    bench = with_deadline()
    sent = bench.start()
    assert bench.node.objects[0x1400, 5] == u16(6)
    assert not [frame for frame in sent if frame.startswith("201#")]
    bench.bus.synchronise()  # another device takes its first readings
    assert bench.sent() == ["080#"]
    assert bench.run(VENTED)[0].startswith("201#")
    bench.driver.make_safe()
    bench.bus.make_safe()
    assert bench.sent()[0] == "201#0000000000"


def test_a_module_without_the_deadline_or_that_does_not_keep_it_is_refused():
    bench = with_deadline()
    del bench.node.objects[0x1400, 5]
    with pytest.raises(ConnectionFailed, match="0x1400:05"):
        bench.driver.connect()
    bench = with_deadline()
    bench.node.stubborn.add((0x1400, 5))
    with pytest.raises(ConnectionFailed, match=r"reads back another.*0x1400:05"):
        bench.driver.connect()


def test_a_deadline_that_one_lost_setpoint_passes_is_refused():
    bench = Regulators()
    bench.bus.period = 4e-3
    settings = replace(SETTINGS, node=2, setpoint_deadline=6e-3)
    with pytest.raises(ConfigurationError, match=r"setpoint_deadline \(0\.006 s\).*two cycles"):
        Cia401Regulators("others", settings, bench.bus)


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


# Configuration that goes wrong ------------------------------------------------------------


def test_an_absent_node_is_named():
    bench = Regulators()
    bench.node.silent = True
    with pytest.raises(ConnectionFailed, match=r"valves \(node 0x01\): it did not.*0x1000:00"):
        bench.driver.connect()


@pytest.mark.parametrize(
    ("thing", "value", "words"),
    [
        ((0x1000, 0), u32(0x00080196), "another kind of device.*CiA 406"),
        ((0x1001, 0), u8(0x05), "reports an error.*generic, voltage"),
        ((0x6443, 1), u16(0), "another size.*0x6443:01.*2 bytes"),
    ],
)
def test_a_wrong_object_is_named(thing, value, words):
    bench = Regulators()
    bench.node.objects[thing] = value
    if thing[0] == 0x6443:
        bench.node.stubborn.add(thing)
    with pytest.raises(ConnectionFailed, match=words):
        bench.driver.connect()


@pytest.mark.parametrize("thing", [(0x6443, 2), (0x6444, 1), (0x6207, 1), (0x1029, 1), (0x1016, 1)])
def test_a_safety_object_that_reads_back_otherwise_is_refused(thing):
    bench = Regulators()
    bench.node.stubborn.add(thing)
    with pytest.raises(ConnectionFailed, match=f"reads back another.*0x{thing[0]:04X}:0{thing[1]}"):
        bench.driver.connect()


def test_an_abort_is_told_in_words():
    bench = Regulators()
    bench.node.aborts[0x6444, 2] = 0x06090031
    with pytest.raises(ConnectionFailed, match=r"too high \(abort 0x06090031\).*0x6444:02"):
        bench.driver.connect()


def test_a_node_that_does_not_start_is_named():
    bench = Regulators()
    bench.driver.connect()
    bench.node.answers_start = False
    with pytest.raises(ConnectionFailed, match="did not enter OPERATIONAL"):
        bench.driver.arm()


def test_a_wrong_serial_number_is_refused():
    bench = Regulators()
    bench.driver._serial = 8
    with pytest.raises(ConnectionFailed, match=r"serial number.*0x1018:04.*value 7.*bound 8"):
        bench.driver.connect()


def test_two_devices_with_one_node_number_are_refused():
    bench = Regulators()
    with pytest.raises(ValueError, match="two devices have node number 0x01"):
        Cia406Encoder("rod", Cia406Settings(node=1, stroke=0.1), bench.bus)


# The interface ----------------------------------------------------------------------------


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


# More than one frame each way, and frames that get lost while connecting ------------------


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


def test_a_lost_answer_is_asked_for_again():
    bench = Regulators()
    lost = iter((True, False))
    put = bench.interface.put

    def lossy(*frames, **kind):
        if frames[0].startswith("581#4300") and next(lost, False):
            return
        put(*frames, **kind)

    bench.interface.put = lossy
    bench.driver.connect()
    assert bench.sent().count("601#4000100000000000") == 2
