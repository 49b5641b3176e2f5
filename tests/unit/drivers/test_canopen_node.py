"""One CANopen node from the master's side: what it is asked, and what keeps it from being used."""

import random
import struct

import pytest
from node_fakes import NodeBench

from drivers.can.milliseconds import to_milliseconds
from drivers.canopen.mapping import Entry
from drivers.canopen.node import _show, pdo_id
from rig.hal import ConnectionFailed, DeviceFault

SEEDS = range(3)
LATE = 100.0


@pytest.fixture(params=SEEDS)
def bench(request):
    return NodeBench(random.Random(request.param).randrange(2, 0x70))


def refusal(action, *arguments, **options):
    with pytest.raises(ConnectionFailed) as caught:
        action(*arguments, **options)
    return str(caught.value)


def u16(value):
    return struct.pack("<H", value)


def u32(value):
    return struct.pack("<I", value)


# Connecting -----------------------------------------------------------------------------


def test_connecting_resets_identifies_and_has_both_sides_beat(bench):
    number = bench.number
    assert bench.node.connect(profile=401) == 0x000F
    assert bench.bus.sent == [(0x000, bytes((0x81, number)))]
    assert bench.bus.waits == [0.9]
    assert bench.objects.written == [
        (0x1017, 0, u16(10)),
        (0x1016, 1, u32(0x7E << 16 | 30)),
    ]
    read = [(index, sub) for kind, index, sub, _ in bench.objects.log if kind == "r"]
    assert read == [(0x1000, 0), (0x1001, 0), (0x1017, 0), (0x1016, 1)]


def test_it_is_one_conversation_however_often_it_is_connected(bench):
    bench.node.connect(profile=401)
    bench.node.connect(profile=401)
    assert bench.bus.added == [bench.number]


def test_a_boot_up_that_was_lost_does_not_stop_it(bench):
    bench.states = {}
    assert bench.node.connect(profile=401) == 0x000F
    assert bench.bus.sent == [
        (0x000, bytes((0x81, bench.number))),
        (0x000, bytes((0x80, bench.number))),
    ]


def test_an_emergency_from_before_the_reset_is_forgotten(bench):
    bench.bus.put(0x080 + bench.number, b"\x10\x31\x01")
    assert bench.node.emergency.active is not None
    bench.node.connect(profile=401)
    assert bench.node.emergency.active is None


def test_another_kind_of_device_is_refused(bench):
    said = refusal(bench.node.connect, profile=406)
    for word in ("another kind of device", "0x1000:00", "CiA 401 (0x000F0191)", "CiA 406"):
        assert word in said
    assert f"node 0x{bench.number:02X}" in said


@pytest.mark.parametrize("profile", [0x191 - 1, 0x191 + 1, 0x0F])
def test_only_the_lower_word_is_the_kind(profile):
    assert "bound CiA" in refusal(NodeBench(5).node.connect, profile=profile)


@pytest.mark.parametrize(
    ("what", "sub", "right", "shown"),
    [
        ("vendor", 1, 0x2A, "42 (0x2A)"),
        ("product", 2, 0x401, "1025 (0x401)"),
        ("serial", 4, 0x70009, "458761 (0x70009)"),
    ],
)
def test_who_it_is_must_be_as_the_profile_says(bench, what, sub, right, shown):
    bench.connected(**{what: right})
    assert bench.node.connect(profile=401, **{what: right}) == 0x000F
    wrong = right + random.Random(bench.number).choice((-1, 1, 16))
    said = refusal(bench.node.connect, profile=401, **{what: wrong})
    for word in (f"its {what} number is not the profile's", f"0x1018:{sub:02X}", f"value {shown}"):
        assert word in said
    assert f"bound {wrong} (0x{wrong:X})" in said


@pytest.mark.parametrize("register", [0x01, 0x80, 0x15])
def test_a_node_that_reports_an_error_is_not_used(bench, register):
    bench.objects.objects[0x1001, 0] = bytes([register])
    said = refusal(bench.node.connect, profile=401)
    for word in ("reports an error before it is used", "0x1001:00", f"0x{register:02X} ("):
        assert word in said


@pytest.mark.parametrize(("surplus", "alone"), [(0, True), (1, True), (2, False), (7, False)])
def test_two_devices_of_one_number_answer_more_than_they_were_asked(bench, surplus, alone):
    bench.bus.extra = surplus
    if alone:
        bench.connected()
        return
    said = refusal(bench.node.connect, profile=401)
    assert "several devices have this node number" in said
    assert f"{surplus} answers more than there were questions" in said


def test_times_are_told_into_milliseconds_and_never_none():
    assert [to_milliseconds(s) for s in (0.0, 1e-4, 1e-3, 1.4e-3, 1.6e-3, 0.25)] == [
        1,
        1,
        1,
        1,
        2,
        250,
    ]


# Process data ---------------------------------------------------------------------------

LAYOUT = (Entry(0x6411, 1, "i16"), Entry(0x6200, 1, "u8"))
OFF = 0x8000_0000


def with_pdos(bench, present=range(4)):
    for base in (0x1400, 0x1800):
        for k in present:
            bench.objects.objects |= {
                (base + k, 1): u32(0xC000_0000),
                (base + k, 2): b"\xff",
                (base + k + 0x200, 0): b"\x00",
                **{(base + k + 0x200, sub): bytes(4) for sub in range(1, 9)},
            }
    return bench.connected()


def test_mapping_switches_off_fills_and_switches_on(bench):
    with_pdos(bench, range(2))
    bench.node.map_pdos([LAYOUT], [LAYOUT[:1], LAYOUT[1:]], remap=True)
    keep = 0x4000_0000
    expected = []
    for base, default, k, layout in (
        (0x1400, 0x200, 0, LAYOUT),
        (0x1800, 0x180, 0, LAYOUT[:1]),
        (0x1801, 0x280, 0, LAYOUT[1:]),
    ):
        can_id = default + bench.number
        expected += [(base + k, 1, u32(OFF | keep | can_id)), (base + 0x200, 0, b"\x00")]
        expected += [(base + 0x200, sub, u32(e.code)) for sub, e in enumerate(layout, 1)]
        expected += [
            (base + 0x200, 0, bytes([len(layout)])),
            (base, 2, b"\x01"),
            (base, 1, u32(keep | can_id)),
        ]
    assert bench.objects.written == expected


def test_a_bit_that_says_whether_it_may_be_asked_is_left_as_it_is(bench):
    with_pdos(bench)
    bench.objects.objects[0x1400, 1] = u32(OFF | 0x321)
    bench.node.map_pdos([LAYOUT], [], remap=True)
    (first, *_, last) = [
        data for index, sub, data in bench.objects.written if (index, sub) == (0x1400, 1)
    ]
    assert (first, last) == (u32(OFF | 0x200 + bench.number), u32(0x200 + bench.number))


def test_unused_ones_are_switched_off_if_they_are_there_and_on(bench):
    with_pdos(bench, range(3))
    on = {0x1401: 0x301, 0x1800: 0x4000_0181, 0x1802: 0x381}
    for index, code in on.items():
        bench.objects.objects[index, 1] = u32(code)
    bench.node.map_pdos([], [], remap=True)
    assert bench.objects.written == [(index, 1, u32(OFF | code)) for index, code in on.items()]


def test_four_each_way_are_looked_at(bench):
    with_pdos(bench)
    bench.node.map_pdos([], [], remap=False)
    looked = [index for kind, index, sub, _ in bench.objects.log if (kind, sub) == ("r", 1)]
    assert looked == [0x1400, 0x1401, 0x1402, 0x1403, 0x1800, 0x1801, 0x1802, 0x1803]


def test_a_fixed_mapping_is_compared_and_not_written(bench):
    with_pdos(bench)
    right = {sub: u32(entry.code) for sub, entry in enumerate(LAYOUT, 1)}
    bench.objects.objects |= {(0x1600, sub): code for sub, code in right.items()}
    bench.objects.objects[0x1600, 0] = b"\x02"
    bench.node.map_pdos([LAYOUT], [], remap=False)
    assert all(index == 0x1400 for index, _, _ in bench.objects.written)
    bench.objects.objects[0x1600, 0] = b"\x01"
    said = refusal(bench.node.map_pdos, [LAYOUT], [], remap=False)
    for word in ("fixed mapping is not what the profile needs", "0x1600", "value 64110110,"):
        assert word in said
    assert "bound 64110110 62000108" in said
    bench.objects.objects[0x1600, 0] = b"\x00"
    assert "value nothing" in refusal(bench.node.map_pdos, [LAYOUT], [], remap=False)


def test_deadlines_are_of_the_first_that_it_receives(bench):
    bench.objects.objects |= {(0x1400 + k, 5): bytes(2) for k in range(4)}
    bench.connected().node.set_deadlines(2, None)
    assert bench.objects.written == []
    bench.node.set_deadlines(2, 0.006)
    assert bench.objects.written == [(0x1400, 5, u16(6)), (0x1401, 5, u16(6))]


def test_identifiers_are_of_the_predefined_set():
    assert [pdo_id(1, 5), pdo_id(2, 5), pdo_id(4, 0x7F)] == [0x205, 0x305, 0x57F]


# Starting, watching, stopping -------------------------------------------------------------


def test_it_is_started_once_if_it_says_so(bench):
    bench.connected().node.arm()
    assert bench.bus.sent == [(0x000, bytes((0x01, bench.number)))]
    assert bench.bus.waits == [pytest.approx(0.3)]
    bench.node.check(0.0)


def test_a_start_that_got_lost_is_repeated_twice(bench):
    bench.connected().states = {}
    assert "did not enter OPERATIONAL" in refusal(bench.node.arm)
    assert bench.bus.sent == [(0x000, bytes((0x01, bench.number)))] * 3
    assert bench.bus.waits == [pytest.approx(0.3)] * 3


def test_what_it_said_before_the_start_does_not_count(bench):
    bench.armed().states = {}
    said = refusal(bench.node.arm)
    assert "value unknown" in said and "bound OPERATIONAL" in said


def test_a_node_in_another_state_is_not_started(bench):
    bench.connected().states = {0x01: b"\x7f"}
    assert "value PRE-OPERATIONAL" in refusal(bench.node.arm)


def test_a_node_that_reboots_on_the_way_is_not_started(bench):
    bench.connected()

    def beat(can_id, data):
        bench.bus.put(0x700 + bench.number, b"\x00")
        bench.bus.put(0x700 + bench.number, b"\x05")

    bench.bus.reply = beat
    assert "did not enter OPERATIONAL" in refusal(bench.node.arm)


def test_an_emergency_ends_the_start_at_once(bench):
    bench.connected()
    bench.bus.reply = lambda *_: bench.bus.put(0x080 + bench.number, b"\x10\x31\x01")
    assert "0x3110" in refusal(bench.node.arm)
    assert len(bench.bus.waits) == 1


def test_an_armed_node_is_watched_and_another_is_not(bench):
    bench.connected()
    bench.bus.put(0x080 + bench.number, b"\x10\x31\x01")
    bench.node.check(LATE)  # nothing is expected of it yet
    bench.armed()
    bench.node.check(0.02)
    with pytest.raises(DeviceFault, match=f"node 0x{bench.number:02X}"):
        bench.node.check(LATE)
    bench.bus.put(0x080 + bench.number, b"\x10\x31\x01")
    with pytest.raises(DeviceFault, match="0x3110") as caught:
        bench.node.check(0.02)
    assert caught.value.node == bench.number
    bench.node.disarm()
    bench.node.check(LATE)


def test_nothing_is_expected_of_a_node_that_was_never_started(bench):
    bench.bus.put(0x080 + bench.number, b"\x10\x31\x01")
    bench.node.check(LATE)


def test_a_node_that_is_disarmed_has_no_watch_on_its_heartbeat(bench):
    bench.armed().node.disarm()
    bench.node.heartbeat.check(LATE)
    bench.armed().node.connect(profile=401)
    bench.node.heartbeat.check(LATE)
    bench.node.check(LATE)


def test_a_failed_start_leaves_nothing_armed(bench):
    bench.connected().states = {}
    refusal(bench.node.arm)
    bench.node.check(LATE)
    bench.node.heartbeat.check(LATE)


def test_halting_never_raises(bench):
    bench.connected().node.halt()
    assert bench.bus.sent == [(0x000, bytes((0x02, bench.number)))]
    bench.bus.refusing = OSError("no buffer")
    bench.node.halt()


def test_a_refused_frame_says_why(bench):
    bench.connected().bus.refusing = OSError("no buffer")
    assert "the interface refused a frame: no buffer" in refusal(bench.node.arm)


# Objects --------------------------------------------------------------------------------

CASES = [
    ("u8", 0x80, b"\x80"), ("i8", -2, b"\xfe"), ("u16", 0x1234, b"\x34\x12"),
    ("i16", -3, b"\xfd\xff"), ("u32", 0x8000_0001, b"\x01\x00\x00\x80"),
    ("i32", -5, b"\xfb\xff\xff\xff"), ("f32", 0.5, b"\x00\x00\x00\x3f"),
]  # fmt: skip


@pytest.mark.parametrize(("type", "value", "data"), CASES)
def test_a_value_is_written_read_back_and_read(bench, type, value, data):
    bench.objects.objects[0x2100, 3] = bytes(len(data))
    bench.connected().node.write(0x2100, 3, type, value)
    assert bench.objects.log == [("w", 0x2100, 3, data), ("r", 0x2100, 3, data)]
    assert bench.node.read(0x2100, 3, type) == value


def test_what_was_read_back_is_kept_until_it_connects_again(bench):
    bench.objects.objects[0x2100, 3] = bytes(2)
    bench.connected().node.write(0x2100, 3, "u16", 7.9)
    assert bench.node.written["0x2100:03"] == 7
    bench.objects.objects[0x2100, 4] = bytes(2)
    bench.objects.stubborn[0x2100, 4] = u16(0x0105)
    bench.node.write(0x2100, 4, "u16", 0x0205, mask=0x00FF)
    assert bench.node.written["0x2100:04"] == 0x0105
    bench.connected()
    assert not {"0x2100:03", "0x2100:04"} & bench.node.written.keys()


def test_a_whole_number_is_written_of_any_number(bench):
    bench.objects.objects[0x2100, 3] = bytes(2)
    bench.connected().node.write(0x2100, 3, "u16", 7.9)
    assert bench.objects.objects[0x2100, 3] == u16(7)


@pytest.mark.parametrize("length", [1, 3, 4])
def test_an_object_of_another_size_is_refused(bench, length):
    bench.connected().objects.objects[0x2100, 3] = bytes(length)
    said = refusal(bench.node.read, 0x2100, 3, "u16")
    for word in ("another size than its type", "0x2100:03", f"{length} bytes", "2 bytes (u16)"):
        assert word in said


def test_a_setting_that_reads_back_otherwise_is_refused(bench):
    bench.connected().objects.objects[0x2100, 3] = bytes(2)
    bench.objects.stubborn[0x2100, 3] = u16(0x0105)
    said = refusal(bench.node.write, 0x2100, 3, "u16", 0x0205)
    for word in ("reads back another", "0x2100:03", "value 261 (0x105)", "bound 517 (0x205)"):
        assert word in said
    bench.node.write(0x2100, 3, "u16", 0x0205, mask=0x00FF)
    assert "0x2100:03" in refusal(bench.node.write, 0x2100, 3, "u16", 0x0205, mask=0x0F00)


def test_numbers_are_shown_as_people_and_as_manuals_have_them():
    assert [_show(-1), _show(16), _show(2.5)] == ["-1 (0xFFFFFFFF)", "16 (0x10)", "2.5"]


@pytest.mark.parametrize("code", [0x06020000, 0x06090011])
def test_what_a_node_need_not_have_is_none(bench, code):
    bench.connected().objects.errors[0x2100, 3] = code
    assert bench.node.read_if_present(0x2100, 3, "u16") is None


@pytest.mark.parametrize("error", [0x08000000, OSError("no answer")])
def test_what_it_has_and_does_not_give_is_no_none(bench, error):
    bench.connected().objects.errors[0x2100, 3] = error
    refusal(bench.node.read_if_present, 0x2100, 3, "u16")
    bench.objects.errors.clear()
    bench.objects.objects[0x2100, 3] = bytes(2)
    assert bench.node.read_if_present(0x2100, 3, "u16") == 0


@pytest.mark.parametrize(("kind", "done"), [("read", "read"), ("write", "written")])
def test_a_refusal_is_told_in_words(bench, kind, done):
    def act():
        more = () if kind == "read" else (1,)
        getattr(bench.node, kind)(0x2100, 3, "u16", *more)

    bench.connected().objects.errors[0x2100, 3] = 0x06010002
    said = refusal(act)
    assert f"it refused to have an object {done}: Attempt to write a read only object" in said
    assert "(abort 0x06010002)" in said and "0x2100:03" in said
    bench.objects.errors[0x2100, 3] = 0x12345678
    assert "unknown reason (abort 0x12345678)" in refusal(act)
    bench.objects.errors[0x2100, 3] = TimeoutError("nothing came")
    said = refusal(act)
    assert f"it did not answer when an object was to be {done} (nothing came)" in said
    assert "node number and bit rate" in said and "0x2100:03" in said
    bench.bus.extra = 2
    assert "several devices" in refusal(act)
    bench.objects.errors[0x2100, 3] = ConnectionFailed("can0", "the link is down")
    assert "the link is down" in refusal(act)
    bench.objects.errors[0x2100, 3] = DeviceFault("can0", "bus off")
    with pytest.raises(DeviceFault, match="bus off"):
        act()


def test_answers_go_to_who_asked(bench):
    heard = []
    bench.connected()
    bench.node.asked.ask(0x6041, 0, lambda data, now: heard.append((data, now)))
    assert bench.bus.sent == [(0x600 + bench.number, b"\x40\x41\x60\x00" + bytes(4))]
    mine, other = b"\x4b\x41\x60\x00\x37\x02\x00\x00", b"\x4b\x42\x60\x00\x11\x00\x00\x00"
    bench.bus.put(0x580 + bench.number, mine, 1.5)
    bench.bus.put(0x580 + bench.number, other, 2.5)
    assert heard == [(mine[4:], 1.5)]
    assert bench.bus.answers == [(0x580 + bench.number, other, 2.5)]
