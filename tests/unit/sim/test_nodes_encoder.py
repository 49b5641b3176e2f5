"""The emulated encoder: quantisation, speed from its own samples, presets, alarms."""

import math

import pytest
from emulated_rig import AGONIST


def start_fast(bench):
    """Map position, speed and alarms into TPDO1 on every SYNC."""
    bench.run()
    for index, sub, value, size in (
        (0x1801, 1, 0x800002A0, 4),
        (0x1800, 1, 0x800001A0, 4),
        (0x1A00, 0, 0, 1),
        (0x1A00, 1, 0x60040020, 4),
        (0x1A00, 2, 0x60300110, 4),
        (0x1A00, 3, 0x65030010, 4),
        (0x1A00, 0, 3, 1),
        (0x1800, 2, 1, 1),
        (0x1800, 1, 0x1A0, 4),
    ):
        assert bench.write(AGONIST, index, sub, value, size) == 0
    bench.ask("000#0120")


def sample(bench, period=0.002):
    bench.put("080#")
    frame = bytes.fromhex(bench.run(period)[0][4:])
    assert len(frame) == 8
    return (
        int.from_bytes(frame[:4], "little", signed=True),
        int.from_bytes(frame[4:6], "little", signed=True),
        int.from_bytes(frame[6:], "little"),
    )


def test_it_is_an_absolute_linear_encoder_with_its_units(bench):
    bench.run()
    assert bench.read(AGONIST, 0x1000) == 0x00080196
    assert bench.read(AGONIST, 0x6005, 1) == 1000  # nm
    assert bench.read(AGONIST, 0x6005, 2) == 1  # 0.01 mm/s
    assert bench.read(AGONIST, 0x6501) == 1000
    assert bench.read(AGONIST, 0x6002) == 100_000


def test_position_is_rounded_to_the_step(bench):
    start_fast(bench)
    for position, steps in ((0.0123456789, 12346), (-0.0000016, -2), (0.0, 0)):
        bench.plant.positions[0] = position
        assert sample(bench)[0] == steps


def test_speed_follows_a_ramp_within_the_quantisation(bench):
    start_fast(bench)
    for tick in range(50):
        bench.plant.positions[0] = 0.01 + 0.05 * tick * 0.002
        speed = sample(bench)[1]
    assert speed == pytest.approx(5000, abs=1)  # 50 mm/s in 0.01 mm/s
    for _ in range(10):
        speed = sample(bench)[1]
    assert speed == 0


def test_speed_of_a_sine_lags_by_half_the_window_at_most(bench):
    start_fast(bench)
    worst = 0.0
    for tick in range(1000):
        t = tick * 0.002
        bench.plant.positions[0] = 0.02 * math.sin(2 * math.pi * t)
        speed = sample(bench)[1]
        if tick > 10:
            true = 0.02 * 2 * math.pi * math.cos(2 * math.pi * (t - 0.005))
            worst = max(worst, abs(speed * 1e-5 - true))
    assert worst < 1e-3  # 1 um in 10 ms is 0.1 mm/s


def test_preset_moves_the_reading_and_survives_a_reset(bench):
    bench.run()
    assert bench.write(AGONIST, 0x6003, 0, 0, 4) == 0
    assert bench.read(AGONIST, 0x6004) == 0
    assert bench.read(AGONIST, 0x6509) == (-10_000) % 2**32
    bench.ask("000#8120")
    assert bench.read(AGONIST, 0x6004) == 0


def test_direction_can_be_reversed(bench):
    bench.run()
    assert bench.write(AGONIST, 0x6000, 0, 0x000C, 2) == 0
    assert bench.read(AGONIST, 0x6004) == (-10_000) % 2**32
    assert bench.read(AGONIST, 0x6500) == 0x000C


def test_frozen_encoder_repeats_its_position(bench):
    start_fast(bench)
    before = sample(bench)[0]
    bench.rig.inject("agonist", "frozen")
    bench.plant.positions[0] += 0.005
    assert sample(bench) == (before, 0, 0)
    bench.rig.inject("agonist", "repair")
    assert sample(bench)[0] == before + 5000


def test_an_encoder_that_nobody_has_asked_yet_freezes_where_it_is(bench):
    bench.rig.inject("agonist", "frozen")
    bench.plant.positions[0] += 0.005
    bench.run()
    assert bench.read(AGONIST, 0x6004) == 10_000
    assert bench.write(AGONIST, 0x6000, 0, 0x000C, 2) == 0
    assert bench.read(AGONIST, 0x6004) == (-10_000) % 2**32
    bench.rig.inject("agonist", "repair")
    assert bench.read(AGONIST, 0x6004) == (-15_000) % 2**32


def test_jump(bench):
    start_fast(bench)
    before = sample(bench)[0]
    bench.rig.inject("agonist", "jump", -0.002)
    assert sample(bench)[0] == before - 2000


def test_alarm_sets_its_bit_and_sends_an_emergency(bench):
    start_fast(bench)
    bench.rig.inject("agonist", "alarm")
    assert bench.run() == ["0A0#0073210000000000"]
    assert sample(bench)[2] == 1
    assert bench.read(AGONIST, 0x6503) == 1
    bench.rig.inject("agonist", "repair")
    assert bench.run() == ["0A0#0000000000000000"]
    assert sample(bench)[2] == 0


def test_faults_of_its_measurement_are_in_its_frames_until_they_are_repaired(bench):
    start_fast(bench)
    bench.plant.positions[0] = 0.030
    assert sample(bench)[0] == 30_000
    bench.rig.inject("agonist", "drift", 0.5)
    began, drifted = sample(bench)[0], sample(bench)[0]
    assert drifted - began == pytest.approx(1000, abs=2)  # 0.5 m/s over 2 ms
    bench.rig.inject("agonist", "repair")
    bench.rig.inject("agonist", "mirrored")
    bench.plant.positions[0] = 0.031
    assert sample(bench)[0] == 29_000
    bench.rig.inject("agonist", "repair")
    assert sample(bench)[0] == 31_000
