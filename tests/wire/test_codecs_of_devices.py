"""Bytes ↔ SI by tables: what data sheets say a count means."""

import struct
from dataclasses import replace

import pytest

from drivers.cia401.channel_settings import MonitorSignal, SetpointSignal
from drivers.cia401.codec import (
    encode_pressure,
    monitor_codec,
    pressure_decoder,
    setpoint_codec,
)
from drivers.cia402.codec import DriveCodec
from drivers.cia402.settings import DriveSettings
from drivers.cia406.codec import decode_velocity, linear_codec, position_decoder
from drivers.cia406.settings import Cia406Settings

BAR = 1e5
PLAIN = SetpointSignal(sub=1, voltage=(0.0, 10.0), pressure=(0.0, 9 * BAR))
EXTENDED = replace(PLAIN, raw=(0.0, 30518.0))  # 0x7736 at 10 V
TWELVE_BIT = replace(PLAIN, raw=(0.0, 4095.0), type="u16")
OFFSET = replace(PLAIN, pressure=(0.2 * BAR, 5.2 * BAR))
FLOAT = replace(PLAIN, type="f32", raw=(0.0, 10.0))


@pytest.mark.parametrize(
    ("signal", "pressure", "data"),
    [
        (PLAIN, 0.0, "0000"),
        (PLAIN, 9 * BAR, "FF7F"),
        (PLAIN, 4.5 * BAR, "0040"),  # 16383.5 is a tie and goes to the even 16384
        (PLAIN, -5.0, "0000"),
        (PLAIN, 20 * BAR, "FF7F"),
        (EXTENDED, 9 * BAR, "3677"),
        (TWELVE_BIT, 9 * BAR, "FF0F"),
        (OFFSET, 0.2 * BAR, "0000"),
        (OFFSET, 0.0, "0000"),
        (OFFSET, 5.2 * BAR, "FF7F"),
        (FLOAT, 4.5 * BAR, "0000A040"),
    ],
)
def test_setpoints_become_these_bytes(signal, pressure, data):
    code = {"i16": "<h", "u16": "<H", "f32": "<f"}[signal.type]
    assert (
        struct.pack(code, encode_pressure(setpoint_codec(signal), pressure)).hex().upper() == data
    )


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_what_is_no_pressure_is_not_encoded(value):
    with pytest.raises(ValueError, match="no number"):
        encode_pressure(setpoint_codec(PLAIN), value)


LIVE_VOLTS = MonitorSignal(
    sub=1, raw=(3276.7, 16383.5), voltage=(1.0, 5.0), pressure=(0.0, 9 * BAR)
)
LOOP = MonitorSignal(sub=1, raw=(0.0, 20000.0), current=(4e-3, 20e-3), pressure=(0.0, 10 * BAR))


@pytest.mark.parametrize(
    ("signal", "data", "pressure", "broken"),
    [
        (LIVE_VOLTS, "CD0C", 0.0, False),  # 3277 counts: 1.0001 V
        (LIVE_VOLTS, "FF3F", 9 * BAR, False),
        (LIVE_VOLTS, "0000", -2.25 * BAR, True),  # 0 V
        (LIVE_VOLTS, "6606", -1.125 * BAR, True),  # 0.49994 V
        (LIVE_VOLTS, "6706", -1.125 * BAR, False),  # 0.50024 V
        (LOOP, "0000", 0.0, False),
        (LOOP, "204E", 10 * BAR, False),
        (LOOP, "0DFE", -0.2495 * BAR, False),  # -499 counts: 3.6008 mA
        (LOOP, "0BFE", -0.2505 * BAR, True),  # 3.5992 mA
        (LOOP, "78EC", -2.5 * BAR, True),  # 0 mA
        (LOOP, "0352", 10.4975 * BAR, False),  # 20.796 mA: over range, not yet shorted
        (LOOP, "8753", 10.6915 * BAR, True),  # 21383 counts: 21.106 mA
    ],
)
def test_monitor_counts_mean_this_pressure_and_this_wire(signal, data, pressure, broken):
    codec = monitor_codec(signal)
    raw = struct.unpack("<h", bytes.fromhex(data))[0]
    assert pressure_decoder(codec)(raw) == pytest.approx(pressure, abs=50.0)
    current = codec.signal_gain * raw + codec.signal_offset
    assert (not codec.broken_below <= current <= codec.broken_above) is broken


def test_more_than_21_mA_is_a_short():
    codec = monitor_codec(LOOP)
    assert codec.broken_above == pytest.approx(21e-3)
    assert codec.broken_below == pytest.approx(3.6e-3)


@pytest.mark.parametrize(
    ("settings", "step", "data", "position"),
    [
        ({}, 1e-6, "00000000", 0.0),
        ({}, 1e-6, "10270000", 10e-3),
        ({}, 1e-4, "64000000", 10e-3),  # 0x6501 = 100 000: 0.1 mm
        ({}, 5e-6, "FFFFFFFF", -5e-6),
        ({"reversed": True, "offset": 50e-3}, 1e-6, "10270000", 40e-3),
        ({"scale": 1.001, "offset": -1e-3}, 1e-6, "10270000", 9.01e-3),
    ],
)
def test_position_counts_mean_this_extension(settings, step, data, position):
    codec = linear_codec(Cia406Settings(node=1, stroke=0.1, **settings), step, 1e-5)
    raw = struct.unpack("<i", bytes.fromhex(data))[0]
    assert position_decoder(codec)(raw) == pytest.approx(position, abs=1e-12)


def test_speed_counts_are_hundredths_of_millimetres_per_second():
    codec = linear_codec(Cia406Settings(node=1, stroke=0.1, reversed=True), 1e-6, 1e-5)
    assert decode_velocity(codec, -150) == pytest.approx(1.5e-3)


@pytest.mark.parametrize(
    ("turned", "counts", "angle"), [(False, 1024, 0.25), (False, 0, 0.1), (True, 1024, -0.05)]
)
def test_a_drives_counts_are_angles_of_its_joint_both_ways(turned, counts, angle):
    gear = 2.0 * 3.141592653589793 / 0.6  # 0.6 rad of the joint for one turn of the shaft
    codec = DriveCodec(
        DriveSettings(node=1, counts_per_turn=4096.0, gear=gear, reversed=turned, offset=0.1)
    )
    assert codec.decode_position(counts) == pytest.approx(angle, abs=1e-12)
    assert codec.encode_position(codec.decode_position(counts)) == counts
    assert codec.decode_velocity(counts) == pytest.approx(angle - 0.1, abs=1e-12)
    assert codec.encode_velocity(codec.decode_velocity(counts)) == counts
