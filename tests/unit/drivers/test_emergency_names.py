"""Emergency codes in words, held against the table of the `canopen` library and the standard's."""

import pytest
from canopen.emcy import EmcyError

from drivers.canopen.emergency import (
    EmergencyLatch,
    decode_emergency,
    describe_code,
    describe_register,
)
from drivers.cia402.errors import describe_error

# The group as the library words it, and a word of what it is called here.
GROUPS = {
    "Error Reset / No Error": "reset",
    "Generic Error": "generic",
    "Current": "current",
    "Voltage": "voltage",
    "Temperature": "temperature",
    "Device Hardware": "hardware",
    "Device Software": "software",
    "Additional Modules": "modules",
    "Monitoring": "monitoring",
    "External Error": "external",
    "Additional Functions": "additional functions",
    "Device Specific": "device specific",
}
# CiA 301, table of emergency error codes: the leading digits, and what they stand for.
CODES = {
    0x1000: "generic error",
    0x2000: "current",
    0x2100: "current at the device's input",
    0x2200: "current inside the device",
    0x2300: "current at the device's output",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3200: "voltage inside the device",
    0x3300: "output voltage",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4200: "device temperature",
    0x5000: "device hardware",
    0x6000: "device software",
    0x6100: "internal software",
    0x6200: "user software",
    0x6300: "data set",
    0x7000: "additional modules",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun, frames lost",
    0x8120: "CAN in error passive mode",
    0x8130: "the master's heartbeat or node guarding failed",
    0x8140: "recovered from bus-off",
    0x8150: "CAN identifier collision",
    0x8200: "protocol error",
    0x8210: "PDO not processed: wrong length",
    0x8220: "PDO length exceeded",
    0x8230: "destination object of a multiplexed PDO not available",
    0x8240: "SYNC with unexpected length",
    0x8250: "RPDO did not come in time",
    0x9000: "external error",
    0xF000: "additional functions",
    0xFF00: "device specific",
    # CiA 401: analogue and digital modules.
    0x2310: "current at the outputs too high",
    0x2320: "short circuit at the outputs",
    0x2330: "load dump at the outputs",
    0x3110: "mains voltage too high",
    0x3120: "mains voltage too low",
    0x3210: "internal voltage too high",
    0x3220: "internal voltage too low",
    0x3310: "output voltage too high",
    0x3320: "output voltage too low",
}


def test_every_group_that_the_library_knows_has_a_name_here():
    assert {text for _, _, text in EmcyError.DESCRIPTIONS} <= set(GROUPS)
    for code, mask, text in EmcyError.DESCRIPTIONS:
        assert EmcyError(code, 0, b"", 0.0).get_desc() == text
        assert GROUPS[text] in describe_code(code).lower(), f"0x{code:04X} of mask 0x{mask:04X}"


def test_each_sub_group_belongs_to_the_group_that_the_library_sees_in_it():
    parts = {
        "Monitoring": ("monitoring", "communication", "protocol"),
        "Device Software": ("software", "data set"),
    }
    seen = set()
    for code in range(0x000B, 0x10000, 0x0100):
        theirs = EmcyError(code, 0, b"", 0.0).get_desc()
        ours = describe_code(code)
        if theirs:  # it knows no sub-groups of 0x1000, 0x5000, 0x7000 and 0x9000
            seen.add(theirs)
            words = parts.get(theirs, (GROUPS[theirs],))
            assert any(word in ours for word in words), f"0x{code:04X}: {theirs}, not {ours}"
    assert seen == set(GROUPS)


@pytest.mark.parametrize(("code", "words"), CODES.items())
def test_codes_have_the_names_of_the_standard(code, words):
    assert describe_code(code) == words


def test_what_has_no_name_is_called_after_the_next_group_up():
    assert describe_code(0x2315) == "current at the device's output"
    assert describe_code(0x2F01) == "current"
    assert describe_code(0x1F01) == "generic error"
    assert describe_code(0xF123) == "additional functions"
    assert describe_code(0xA001) == describe_code(0xE000) == "unknown group"


@pytest.mark.parametrize(("code", "reset"), [(0x0000, True), (0x00FF, True), (0x0100, False)])
def test_codes_below_0x100_say_that_errors_are_gone(code, reset):
    emergency = decode_emergency(code.to_bytes(2, "little") + bytes(6))
    assert (emergency.code, emergency.is_reset) == (code, reset)
    assert (describe_code(code) == "error reset") is reset


def test_the_bits_of_the_error_register_have_the_names_of_object_0x1001():
    names = [
        "generic", "current", "voltage", "temperature", "communication", "device profile",
        "reserved", "manufacturer",
    ]  # fmt: skip
    assert [describe_register(1 << bit) for bit in range(8)] == names
    assert describe_register(0x81) == "generic, manufacturer"
    assert describe_register(0) == ""


def test_an_emergency_says_its_code_register_and_bytes():
    said = str(decode_emergency(bytes.fromhex("10 81 11 01 00 00 00 FE")))
    assert said == (
        "EMCY 0x8110 (CAN overrun, frames lost), error register 0x11 (generic, communication), "
        "maker's bytes 01 00 00 00 FE"
    )
    assert str(decode_emergency(bytes.fromhex("10 81"))) == "EMCY 0x8110 (CAN overrun, frames lost)"


@pytest.mark.parametrize(
    ("data", "emergency"),
    [
        (b"", (0xFF00, 0, bytes(5))),
        (b"\x10", (0xFF00, 0, bytes(5))),
        (b"\x10\x81", (0x8110, 0, bytes(5))),
        (b"\x10\x81\x05", (0x8110, 5, bytes(5))),
        (b"\x10\x81\x05\x01\x02\x03\x04\x05\x06", (0x8110, 5, b"\x01\x02\x03\x04\x05")),
    ],
)
def test_an_emergency_of_another_length_is_taken_as_far_as_it_goes(data, emergency):
    assert decode_emergency(data) == emergency


def test_the_first_error_stays_until_it_is_cleared():
    latch = EmergencyLatch()
    for code in (0x0000, 0x8110, 0x8120, 0x0000):
        latch.receive(code.to_bytes(2, "little") + bytes(6), 0.0)
    assert (latch.active.code, latch.count) == (0x8110, 4)
    latch.clear()
    assert (latch.active, latch.count) == (None, 4)
    latch.receive(b"\x20\x81" + bytes(6), 0.0)
    assert latch.active.code == 0x8120


def test_a_drives_own_names_come_before_those_of_any_device():
    assert describe_error(0x2310) == "continuous over-current at the motor"
    assert describe_error(0x8611) == "following error too large"
    assert describe_error(0x8699) == "positioning"
    assert describe_error(0x8130) == "the master's heartbeat or node guarding failed"
    assert describe_error(0x4000) == "temperature"


def test_setpoints_were_not_taken_by_three_codes_only():
    """CiA 301: wrong length (0x8210), too long (0x8220), and not in time (0x8250)."""
    about = [
        code
        for code in range(0x10000)
        if decode_emergency(code.to_bytes(2, "little") + bytes(6)).is_about_setpoints
    ]
    assert about == [0x8210, 0x8220, 0x8250]
