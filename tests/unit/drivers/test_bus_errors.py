"""What an interface says of itself: which errors are a fault, at once or when they last."""

import errno
import random

import can
import pytest

from drivers.can.errors import BusErrors, error_number
from rig.hal import DeviceFault

BUS_OFF, CONTROLLER, RESTARTED = 0x040, 0x004, 0x100
MOST = 3


def complaint(errors):
    with pytest.raises(DeviceFault) as caught:
        errors.check()
    assert errors.latched and errors.fault is caught.value
    return str(caught.value)


def assert_well(errors):
    errors.check()
    assert not errors.latched and errors.fault is None


@pytest.mark.parametrize(
    ("classes", "data", "words"),
    [
        (BUS_OFF, b"", "went bus-off"),
        (BUS_OFF | RESTARTED, b"", "went bus-off"),
        (RESTARTED, b"", "restarted after bus-off"),
        (CONTROLLER, bytes([0, 0x10]), "error passive"),
        (CONTROLLER, bytes([0, 0x20, 0, 0]), "error passive"),
        (CONTROLLER | RESTARTED, bytes([0, 0x30]), "restarted after bus-off"),
    ],
)
def test_error_frames_that_are_a_fault(classes, data, words):
    errors = BusErrors("can0", MOST)
    errors.receive(classes, data)
    assert words in complaint(errors)
    assert errors.error_frames == 1


@pytest.mark.parametrize(
    ("classes", "data"),
    [
        (0, b""), (0x002, bytes(8)), (CONTROLLER, b""), (CONTROLLER, b"\x30"),
        (CONTROLLER, bytes([0x30, 0x00])), (CONTROLLER, bytes([0, 0x0C])), (0x008, b"\x00\x33"),
    ],
)  # fmt: skip
def test_error_frames_that_are_counted_alone(classes, data):
    errors = BusErrors("can0", MOST)
    errors.receive(classes, data)
    assert_well(errors)
    assert (errors.error_frames, errors.lost) == (1, 0)


@pytest.mark.parametrize("flag", [0x01, 0x02, 0x03])
def test_error_frames_that_say_that_frames_were_lost_are_counted_apart(flag):
    errors = BusErrors("can0", MOST)
    errors.receive(CONTROLLER, bytes([0, flag]))
    assert_well(errors)
    assert (errors.error_frames, errors.lost) == (1, 1)


@pytest.mark.parametrize("code", [errno.ENOBUFS, errno.EAGAIN])
@pytest.mark.parametrize("wrapped", [False, True])
def test_a_full_queue_is_a_fault_once_it_lasts(code, wrapped):
    error = can.CanOperationError("full", code) if wrapped else OSError(code, "full")
    errors = BusErrors("can0", MOST)
    for _ in range(5):
        for _ in range(MOST):
            errors.refuse(error)
        assert_well(errors)
        errors.sent()
    assert errors.refused == 5 * MOST
    for _ in range(MOST + 1):
        errors.refuse(error)
    said = complaint(errors)
    assert "transmit queue is full" in said
    assert f"{MOST + 1} cycles refused" in said and f"{MOST} cycles in a row" in said


@pytest.mark.parametrize("code", [errno.ENETDOWN, errno.ENODEV, errno.ENXIO])
@pytest.mark.parametrize("way", ["refuse", "lose"])
def test_a_link_that_is_down_is_a_fault_at_once(code, way):
    errors = BusErrors("can0", MOST)
    getattr(errors, way)(OSError(code, "gone"))
    assert "went down while in use" in complaint(errors)


@pytest.mark.parametrize(
    "error", [OSError(errno.EIO, "broken"), can.CanError("odd"), ValueError("odd")]
)
def test_any_other_error_is_a_fault_in_its_own_words(error):
    errors = BusErrors("can0", MOST)
    errors.refuse(error)
    assert f"refused a frame: {error}" in complaint(errors)
    errors = BusErrors("can0", MOST)
    errors.lose(error)
    assert f"failed while receiving: {error}" in complaint(errors)


def test_another_master_is_a_fault():
    errors = BusErrors("can0", MOST)
    errors.share("a SYNC that is not ours")
    assert "another master is on the bus: a SYNC that is not ours" in complaint(errors)


@pytest.mark.parametrize("seed", range(10))
def test_the_first_fault_stays_whatever_comes_after_it(seed):
    faults = {
        "bus-off": lambda errors: errors.receive(BUS_OFF, b""),
        "restarted": lambda errors: errors.receive(RESTARTED, b""),
        "passive": lambda errors: errors.receive(CONTROLLER, b"\x00\x10"),
        "link down": lambda errors: errors.lose(OSError(errno.ENETDOWN, "down")),
        "another master": lambda errors: errors.share("a heartbeat"),
        "refused a frame": lambda errors: errors.refuse(ValueError("odd")),
    }
    words = random.Random(seed).sample(sorted(faults), len(faults))
    errors = BusErrors("can0", MOST)
    for word in words:
        faults[word](errors)
        errors.sent()
        assert words[0] in complaint(errors)


def test_the_number_of_an_error_is_found_where_it_is_kept():
    assert error_number(OSError(errno.EIO, "broken")) == errno.EIO
    assert error_number(can.CanOperationError("broken", 7)) == 7
    assert error_number(ValueError("no number")) is None


@pytest.mark.parametrize("other", [0x001, 0x002, 0x008, 0x010, 0x020, 0x080, 0x200])
def test_other_classes_are_counted_and_no_fault(other):
    errors = BusErrors("can0", 3)
    errors.receive(other, b"\xff" * 8)
    errors.check()
    assert (errors.error_frames, errors.lost, errors.latched) == (1, 0, False)
