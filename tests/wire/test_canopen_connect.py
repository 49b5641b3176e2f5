"""What is refused or asked for again while regulators connect."""

from dataclasses import replace

import pytest
from cia401_bench import SETTINGS, VENTED, Regulators
from scripted_bus import u8, u16, u32

from drivers.cia401.device import Cia401Regulators
from drivers.cia406.device import Cia406Encoder
from drivers.cia406.settings import Cia406Settings
from rig.hal import ConfigurationError, ConnectionFailed


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
