"""Frames in words: byte tables from the standard and the manuals, in a profile's names."""

from pathlib import Path

import pytest

from drivers.can.frame import ERROR_FLAG, EXTENDED_FLAG, REMOTE_FLAG
from rig.assembly import REGISTRY
from rig.assembly.decoding import make_decoders
from rig.config import load_profile

CONFIGS = Path(__file__).parents[2] / "configs"


def decoder(rig, *options):
    if rig == "cylinder":  # without its setpoints, the monitors and the inputs are one frame
        options = ("devices.regulators.echo=false", *options)
    profile = load_profile(rig, REGISTRY, options, [CONFIGS])
    return make_decoders(profile)["can0"]


def frame(text):
    can_id, _, data = text.partition("#")
    return int(can_id, 16), bytes.fromhex(data)


@pytest.mark.parametrize(
    ("text", "device", "service", "words"),
    [
        ("000#0110", "regulators", "NMT", "start"),
        ("000#8100", "all nodes", "NMT", "reset node"),
        ("000#8220", "encoder-agonist", "NMT", "reset communication"),
        ("080#", "", "SYNC", ""),
        ("710#05", "regulators", "heartbeat", "OPERATIONAL"),
        ("720#00", "encoder-agonist", "heartbeat", "booting"),
        ("77F#05", "master", "heartbeat", "OPERATIONAL"),
        ("710#", "regulators", "heartbeat", "wrong length, 0 bytes"),
        ("610#4000100000000000", "regulators", "SDO", "read? 0x1000:00 device type"),
        ("590#6017100000000000", "regulators", "SDO", "written 0x1017:00"),
        ("590#8000500000000206", "regulators", "SDO", "no such object (0x06020000) 0x5000:00"),
        ("590#4108100013000000", "regulators", "SDO", "read 19 bytes 0x1008:00"),
        ("590#0065006D00750074", "regulators", "SDO", "segment"),
        ("610#6000000000000000", "regulators", "SDO", "segment"),
        ("090#3081110000000000", "regulators", "EMCY", "EMCY 0x8130"),
        ("190#00", "regulators", "TPDO1", "wrong length, 1 bytes where 5 are mapped"),
    ],
)
def test_services_of_canopen(text, device, service, words):
    decoded = decoder("cylinder").decode(*frame(text))
    assert (decoded.device, decoded.service, decoded.known) == (device, service, True)
    assert words in decoded.text
    assert decoded.text or not words


@pytest.mark.parametrize(
    ("text", "values"),
    [
        # 1 V … 5 V are 3277 … 16384 counts and 0 … 500 kPa: 3277 is no pressure.
        ("190#CD0C004001", [("agonist pressure", 0.0, "Pa"), ("antagonist pressure", 500e3, "Pa"),
                            ("stop", "released", "")]),
        ("190#CD0CCD0C00", [("agonist pressure", 0.0, "Pa"), ("antagonist pressure", 0.0, "Pa"),
                            ("stop", "pressed", "")]),
        ("210#FF7F000001", [("agonist setpoint", 500e3, "Pa"), ("antagonist setpoint", 0.0, "Pa"),
                            ("supply", "open", "")]),
        ("610#2B1164010040", [("agonist setpoint", 16384 / 32767 * 500e3, "Pa")]),
        ("610#2F43640101", [("", "0x01", "")]),
    ],
)  # fmt: skip
def test_pressures_in_si(text, values):
    can_id, data = frame(text)
    if can_id == 0x610:
        data = data.ljust(8, b"\0")
    found = decoder("cylinder").decode(can_id, data).values
    assert [(value.name, value.unit) for value in found] == [(n, u) for n, _, u in values]
    for value, (_, expected, _) in zip(found, values, strict=True):
        if isinstance(expected, float):
            assert value.value == pytest.approx(expected, abs=20.0)  # raw ends are whole counts
        else:
            assert value.value == expected


def test_setpoints_that_a_module_sends_back_are_pressures_too():
    found = decoder("cylinder", "devices.regulators.echo=true").decode(0x190, bytes.fromhex(
        "CD0C0040" "00400000"
    )).values  # fmt: skip
    values = {value.name: value.value for value in found}
    assert values["antagonist pressure"] == pytest.approx(500e3)
    assert values["agonist setpoint"] == pytest.approx(250e3, rel=1e-3)


def test_valves_that_lock_a_chamber_are_shown_one_by_one():
    monitor = decoder("cylinder", "devices.regulators.channels.agonist.lock_bit=3")
    valves = monitor.decode(*frame("210#0000000009")).values[-1]
    assert (valves.name, valves.value) == ("valves", "supply open, agonist lock open")
    valves = monitor.decode(*frame("210#0000000001")).values[-1]
    assert valves.value == "supply open, agonist lock shut"


def test_an_encoders_counts_become_metres_when_it_has_said_its_step():
    monitor = decoder("cylinder")
    sample = frame("1A0#10270000ECFF0000")
    before = monitor.decode(*sample).values[0]
    assert (before.value, before.unit) == (10000, "")
    monitor.decode(*frame("5A0#43056001E8030000"))  # 1000 nm
    monitor.decode(*frame("5A0#4305600201000000"))  # 0.01 mm/s
    position, speed, alarms = monitor.decode(*sample).values
    assert (position.value, position.unit) == (pytest.approx(0.01), "m")
    assert (speed.value, speed.unit) == (pytest.approx(-2e-4), "m/s")
    assert alarms.value == "0x0000"
    given = decoder("cylinder", "devices.encoder-agonist.step=2 um")
    assert given.decode(*sample).values[0].value == pytest.approx(0.02)


def test_an_encoders_eds_tells_its_step_until_it_says_another():
    """A monitor that listens to a running rig never hears it being asked."""
    option = f"devices.encoder-agonist.eds={CONFIGS / 'eds' / 'cia406-linear.eds'}"
    monitor = decoder("cylinder", option)
    sample = frame("1A0#10270000ECFF0000")
    assert monitor.decode(*sample).values[0].value == pytest.approx(0.01)
    monitor.decode(*frame("5A0#43056001D0070000"))
    assert monitor.decode(*sample).values[0].value == pytest.approx(0.02)


def test_drives_in_radians_and_words():
    monitor = decoder("arm")
    control, target, mode = monitor.decode(*frame("201#0F000020030008")).values
    assert (control.value, mode.value) == ("enable operation", "csp")
    # 524288 counts a turn behind a gear of 100: 0x032000 counts
    assert target.value == pytest.approx(0x032000 / 52_428_800 * 6.283185307179586)
    assert target.unit == "rad"
    status, position, _ = monitor.decode(*frame("181#371200E0FCFF08")).values
    assert status.value == "0x1237 OPERATION ENABLED"
    assert position.value == pytest.approx(-target.value)
    torque = monitor.decode(*frame("281#00000000F6FF1186")).values[1]
    assert (torque.value, torque.unit) == (-10, "")
    monitor.decode(*frame("581#43766000E8030000"))  # 1 N m of the motor
    _, torque, error = monitor.decode(*frame("281#00000000F6FF1186")).values
    assert (torque.value, torque.unit) == (pytest.approx(-1.0), "N m")
    assert "following error" in error.value


@pytest.mark.parametrize(
    ("can_id", "service"),
    [
        (0x733, "heartbeat"),  # a node that the profile does not have
        (0x290, "TPDO2"),  # a PDO that it does not use
        (0x7E5, "unknown"),  # LSS
        (0x181 | EXTENDED_FLAG, "unknown"),
        (0x190 | REMOTE_FLAG, "unknown"),
    ],
)
def test_what_the_profile_does_not_know_is_marked(can_id, service):
    decoded = decoder("cylinder").decode(can_id, b"\0")
    assert (decoded.service, decoded.known) == (service, False)


def test_error_frames_are_known_on_every_bus():
    for rig in ("cylinder", "arm-odrive"):
        decoded = decoder(rig).decode(ERROR_FLAG | 0x40, bytes(8))
        assert (decoded.service, decoded.known) == ("error frame", True)
        assert "class 0x40" in decoded.text


@pytest.mark.parametrize(
    ("text", "service", "values"),
    [
        ("067#0800000000000000", "Set_Axis_State", [("state", "CLOSED LOOP CONTROL")]),
        ("06B#0300000001000000", "Set_Controller_Mode",
         [("control", "position"), ("input", "passthrough")]),
        ("061#0000000108000100", "Heartbeat",
         [("state", "CLOSED LOOP CONTROL"),
          ("errors", "watchdog expired, setpoints did not come in time")]),
        ("060#0004030400060B00", "Get_Version", [("hardware", "4.3.4"), ("firmware", "0.6.11")]),
    ],
)  # fmt: skip
def test_golden_frames_of_cansimple_in_words(text, service, values):
    decoded = decoder("arm-odrive").decode(*frame(text))
    assert (decoded.device, decoded.service) == ("drives q3", service)
    assert [(value.name, value.value) for value in decoded.values] == values


def test_golden_setpoint_of_cansimple_in_radians():
    """1.5 turns, 2 turn/s and −0.25 N m, node 3."""
    profile = load_profile("arm-odrive", REGISTRY, (), [CONFIGS])
    joint = profile.devices["drives"].settings.joints["q3"]
    decoded = decoder("arm-odrive").decode(*frame("06C#0000C03FD00706FF"))
    target, feedforward, _ = decoded.values
    assert target.value == pytest.approx(1.5 / joint.turns_per_radian + joint.offset)
    assert feedforward.value == pytest.approx(2.0 / joint.turns_per_radian)
    current = decoder("arm-odrive").decode(*frame("06F#000020410000A041")).values[1]
    assert (current.value, current.unit) == (20.0, "A")


def test_requests_foreign_axes_and_short_frames_of_cansimple():
    monitor = decoder("arm-odrive")
    assert monitor.decode(0x060 | REMOTE_FLAG, b"").text == "asked for"
    assert monitor.decode(0x7E6 | REMOTE_FLAG, b"").device == "all axes"
    assert not monitor.decode(0x0A9 + 0x200, bytes(8)).known
    assert monitor.decode(0x069, b"\0").text == "wrong length, 1 bytes"


def test_names_of_objects_come_from_the_devices_own_eds():
    option = f"devices.regulators.eds={CONFIGS / 'eds' / 'cia401-analogue.eds'}"
    decoded = decoder("cylinder", option).decode(*frame("610#2F43640101000000"))
    (value,) = decoded.values
    assert value.name == "Analogue output error mode / Error mode of output 1"
    assert value.value == 1
