"""What is refused before a CiA 402 drive moves: settings, and drives that are not right."""

import pytest
from cia402_bench import Drive, joint
from scripted_bus import Bench, u8, u16, u32

from drivers.cia402.device import Cia402Servos
from drivers.cia402.settings import Cia402Settings
from rig.hal import ConnectionFailed

# Settings --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: joint(limits=(1.0, -1.0)), "limits: the lower limit 1 is not below"),
        (lambda: joint(offset=1e9), "32-bit position"),
        (lambda: Cia402Settings(joints={"a": joint(), "b": joint()}), "joints a and b.*0x03"),
        (
            lambda: Cia402Settings(joints={"a": joint()}, feedback=("torque", "torque")),
            "named twice",
        ),
        (lambda: Cia402Settings(joints={"a": joint()}, hold_after=9), "fault_after"),
    ],
)
def test_settings_that_cannot_be_right_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_bus_without_a_period_is_refused():
    bench = Bench()
    with pytest.raises(ValueError, match="no period"):
        Cia402Servos("arm", Cia402Settings(joints={"a": joint()}), bench.bus)


# Drives ----------------------------------------------------------------------------------


def test_another_kind_of_device_is_refused():
    with pytest.raises(ConnectionFailed, match=r"arm joint elbow \(node 0x03\).*another kind"):
        Drive(device_type=0x000F0191).connect()
    with pytest.raises(ConnectionFailed, match="frequency converter"):
        Drive(device_type=0x00010192).connect()


@pytest.mark.parametrize(
    ("objects", "message"),
    [
        ({(0x6502, 0): u32(0x100)}, r"does not know the mode csp.*0x6502.*bit 7"),
        ({(0x6092, 1): u32(4000), (0x6092, 2): u32(1)}, r"position unit.*4000 counts per turn"),
        (
            {
                (0x608F, 1): u32(400),
                (0x608F, 2): u32(1),
                (0x6091, 1): u32(3),
                (0x6091, 2): u32(1),
            },
            r"position unit.*1200 counts per turn",
        ),
    ],
)
def test_wrong_modes_and_units_are_refused(objects, message):
    bench = Drive()
    bench.node.objects |= objects
    with pytest.raises(ConnectionFailed, match=message):
        bench.connect()


def test_a_right_unit_is_accepted():
    bench = Drive(counts_per_turn=4096.0)
    bench.node.objects |= {(0x6092, 1): u32(8192), (0x6092, 2): u32(2)}
    bench.connect()


@pytest.mark.parametrize("index", [0x605A, 0x605E, 0x6007, 0x607D, 0x6085, 0x60C2, 0x6065])
def test_a_safety_setting_that_is_not_kept_is_named(index):
    bench = Drive()
    sub = 1 if index in (0x607D, 0x60C2) else 0
    bench.node.stubborn.add((index, sub))
    bench.node.objects[index, sub] = bytes(len(bench.node.objects[index, sub]))
    with pytest.raises(ConnectionFailed, match=rf"reads back another.*0x{index:04X}:{sub:02X}"):
        bench.connect()


def test_a_setting_that_is_refused_is_named_unless_the_profile_knows_that_it_is_absent():
    bench = Drive()
    del bench.node.objects[0x605B, 0]
    with pytest.raises(ConnectionFailed, match=r"refused.*0x605B:00"):
        bench.connect()
    bench = Drive(absent=(0x605B,))
    del bench.node.objects[0x605B, 0]
    assert not [frame for frame in bench.connect() if "5B60" in frame]


def test_an_offset_that_somebody_left_is_cleared():
    bench = Drive()
    bench.node.objects |= {(0x60B1, 0): u32(77), (0x60B2, 0): u16(5)}
    bench.connect()
    assert bench.node.objects[0x60B1, 0] == bytes(4)
    assert bench.node.objects[0x60B2, 0] == bytes(2)


def test_a_drive_in_a_fault_is_refused_in_words():
    bench = Drive()
    bench.node.objects |= {
        (0x1001, 0): u8(0x21),
        (0x603F, 0): u16(0x3210),
        (0x6041, 0): u16(0x0218),
    }
    with pytest.raises(ConnectionFailed) as caught:
        bench.connect()
    text = str(caught.value)
    for part in ("joint elbow", "node 0x03", "over-voltage of the DC link", "0x3210", "0x0218"):
        assert part in text


def test_a_joint_outside_its_limits_is_not_energised():
    bench = Drive()
    bench.connect()
    with pytest.raises(ConnectionFailed, match=r"outside its limits.*2.1 rad.*-1 … 2 rad"):
        bench.arm(2100)


def test_a_limit_of_torque_needs_the_rated_one():
    drive = Drive(max_torque=3.0)
    drive.node.objects[0x6076, 0] = u32(0)
    with pytest.raises(ConnectionFailed, match=r"does not say its rated torque.*max_torque 3 N m"):
        drive.connect()
