"""A linear encoder's frames: what is taken, what is held, and what is a fault."""

import pytest
from scripted_bus import Bench, ScriptedNode, common_objects, u16, u32

from drivers.cia406.device import Cia406Encoder
from drivers.cia406.settings import Cia406Settings, PositionObject
from rig.hal import ConnectionFailed, DeviceFault

AT_10_MM = "1A0#1027000000000000"
AT_11_MM = "1A0#F82A000000000000"


class Encoder(Bench):
    def __init__(self, **settings):
        super().__init__()
        objects = common_objects(0x00080196) | {
            (0x6005, 1): u32(1000),
            (0x6005, 2): u32(1),
            (0x6503, 0): u16(0),
            (0x6509, 0): u32(0),
        }
        self.node = ScriptedNode(self.interface, 0x20, objects)
        defaults = {"node": 0x20, "stroke": 0.06, "max_speed": 0.5}
        self.driver = Cia406Encoder("rod", Cia406Settings(**defaults | settings), self.bus)

    def start(self, first=AT_10_MM):
        self.driver.connect()
        self.node.sync_answers.append(first)
        self.driver.arm()
        self.clock.sleep_until(self.clock.now() + 0.001)
        self.sent()
        return self

    def run(self, *frames):
        self.interface.put(*frames)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.transmit(now)
        self.clock.sleep_until(now + 0.002)


def test_position_and_speed_are_decoded_and_stamped():
    rod = Encoder().start()
    t = rod.clock.now()
    rod.run()
    rod.run("1A0#742700009CFF0000")  # 10.1 mm, -1 mm/s
    assert rod.driver.position() == (pytest.approx((10.1e-3,)), t)
    assert rod.driver.velocity() == (pytest.approx((-1e-3,)), t)


@pytest.mark.parametrize(
    ("settings", "mapping"),
    [
        ({}, [0x60040020, 0x60300110, 0x65030010]),
        ({"speed": None}, [0x60040020, 0x65030010]),
        ({"alarms": "off"}, [0x60040020, 0x60300110]),
        ({"position": PositionObject(0x6020, 2)}, [0x60200220, 0x60300110, 0x65030010]),
    ],
)
def test_what_the_profile_names_is_mapped(settings, mapping):
    rod = Encoder(**settings)
    rod.driver.connect()
    objects = rod.node.objects
    assert objects[0x1A00, 0] == bytes((len(mapping),))
    mapped = [objects[0x1A00, sub] for sub in range(1, len(mapping) + 1)]
    assert mapped == [u32(code) for code in mapping]
    assert objects[0x1800, 1] == u32(0x400001A0)
    assert objects[0x1800, 2] == b"\x01"


def test_the_step_is_the_devices():
    rod = Encoder()
    rod.node.objects[0x6005, 1] = u32(5000)
    rod.start("1A0#D007000000000000")
    assert rod.driver.position().value == pytest.approx((10e-3,))


def test_a_device_that_tells_no_step_needs_one_from_the_profile():
    rod = Encoder()
    del rod.node.objects[0x6005, 1]
    with pytest.raises(ConnectionFailed, match=r"does not tell its measuring step.*0x6005:01"):
        rod.driver.connect()
    rod = Encoder(step=2e-6)
    del rod.node.objects[0x6005, 1]
    assert rod.start().driver.position().value == pytest.approx((20e-3,))


def test_a_step_that_contradicts_the_profile_is_refused():
    with pytest.raises(ConnectionFailed, match=r"step is not the profile's.*1e-06 m.*2e-06 m"):
        Encoder(step=2e-6).driver.connect()


@pytest.mark.parametrize(
    ("thing", "value", "settings", "words"),
    [
        ((0x1000, 0), u32(0x00020196), {}, "rotary"),
        ((0x6503, 0), u16(1), {}, "alarm: position error"),
        ((0x6509, 0), u32(77), {"preset_offset": 0}, "moved by a preset.*77 counts"),
    ],
)
def test_a_device_that_must_not_be_used_is_refused(thing, value, settings, words):
    rod = Encoder(**settings)
    rod.node.objects[thing] = value
    with pytest.raises(ConnectionFailed, match=words):
        rod.driver.connect()


def test_a_fixed_mapping_is_compared_not_written():
    rod = Encoder(remap=False, speed=None, alarms="polled")
    with pytest.raises(ConnectionFailed, match=r"fixed mapping.*value nothing.*bound 60040020"):
        rod.driver.connect()
    rod.node.objects[0x1A00, 0] = b"\x01"
    rod.node.objects[0x1A00, 1] = u32(0x60040020)
    rod.sent()
    rod.driver.connect()
    assert not [frame for frame in rod.sent() if frame.startswith(("620#2F001A", "620#23001A"))]


def test_a_jump_is_a_fault_and_is_not_taken():
    rod = Encoder().start()
    rod.run()
    with pytest.raises(DeviceFault, match=r"rod .*jumped.*0x6004:00.*\+0\.005 m"):
        rod.run("1A0#983A000000000000")
    assert rod.driver.position().value == pytest.approx((10e-3,))


def test_after_lost_frames_the_rod_may_have_gone_further():
    rod = Encoder().start()
    for _ in range(3):
        rod.run()
    rod.run("1A0#102B000000000000")  # 1 mm in two periods of 2 ms: within 0.5 m/s
    assert rod.driver.position().value[0] == pytest.approx(11.024e-3)


def test_a_late_frame_and_the_next_one_in_the_same_cycle_are_no_jump():
    rod = Encoder().start()
    for _ in range(3):
        rod.run()
    rod.run(AT_10_MM)
    rod.run()
    rod.run("1A0#0029000000000000", "1A0#E82A000000000000")  # 10.496 mm, 10.984 mm
    assert rod.driver.position().value[0] == pytest.approx(10.984e-3)


def test_a_counter_that_wraps_is_named():
    rod = Encoder(stroke=3000.0).start("1A0#FFFFFF7F00000000")
    rod.run()
    with pytest.raises(DeviceFault, match="wrapped around"):
        rod.run("1A0#0000008000000000")


def test_an_alarm_in_the_frame_is_a_fault():
    rod = Encoder().start()
    rod.run()
    with pytest.raises(DeviceFault, match=r"position error, bit 12.*0x1001"):
        rod.run("1A0#1027000000000110")


def test_a_position_outside_the_stroke_is_a_fault():
    rod = Encoder().start("1A0#60EA000000000000")
    rod.run()
    with pytest.raises(DeviceFault, match="outside its stroke"):
        for counts in range(60000, 63000, 900):
            rod.run(f"1A0#{counts.to_bytes(4, 'little').hex()}00000000")


def test_a_frozen_encoder_is_a_fault_only_where_noise_is_expected():
    rod = Encoder().start()
    for _ in range(200):
        rod.run(AT_10_MM, "720#05")
    rod = Encoder(frozen_timeout=0.1).start()
    with pytest.raises(DeviceFault, match=r"frozen.*0\.1 s"):
        for _ in range(200):
            rod.run(AT_10_MM, "720#05")
    rod = Encoder(frozen_timeout=0.1).start()
    for n in range(200):
        rod.run(f"1A0#1{n % 2}27000000000000", "720#05")


def test_more_than_eight_bytes_do_not_fit_one_frame():
    with pytest.raises(ValueError, match="more than the 8 bytes"):
        Cia406Settings(
            node=1,
            stroke=0.1,
            speed=PositionObject(0x2000, 1, "i32"),  # not i16 and too long
        )
