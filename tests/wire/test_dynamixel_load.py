"""How full a serial bus is: computed before anything is opened, and as the wire shows it."""

import pytest
from dynamixel_bench import PERIOD, Bench, joints

from drivers.dynamixel.load import check_serial_load, compute_serial_load
from drivers.dynamixel.settings import DynamixelSettings, SerialBusSettings
from rig.hal import ConfigurationError

LEGS = ("legs", DynamixelSettings(joints=joints(12)))


def load(baudrate, **more):
    return compute_serial_load(SerialBusSettings("x", baudrate=baudrate, **more), [LEGS], 200.0)


def test_twelve_servos_at_200_hz():
    # Setpoints 14 + 12·5, request 14 + 12, answer 8 + 12·19 bytes, and 100 µs to turn round.
    seconds = (74 + 26 + 236) * 10 / 4e6 + 100e-6
    assert load(4_000_000).total == pytest.approx(seconds / PERIOD)
    assert load(4_000_000).total < 0.2
    assert 0.65 < load(1_000_000).total < 0.7
    assert load(4_000_000, fast_sync=False).total < 0.5


def test_a_bus_that_is_too_full_is_refused_with_what_fills_it():
    with pytest.raises(ConfigurationError) as refused:
        check_serial_load("chain", SerialBusSettings("x", baudrate=115_200), [LEGS], 200.0)
    text = str(refused.value)
    assert "bus chain: the load at 200 Hz and 115200 bit/s is 585.3 %, at most 70 %" in text
    assert "allowed: 515.3 % too much. Raise the baud rate, lower the loop's rate (23 Hz" in text
    assert "answer of all" in text
    assert "legs setpoints" in text


@pytest.mark.parametrize("fast", [True, False])
@pytest.mark.parametrize("health", [True, False])
def test_the_wire_carries_what_was_computed(fast, health):
    bench = Bench(12, bus={"fast_sync": fast}, health=health).start()
    bench.cycle(count=3)
    before = bench.bus.statistics()
    bench.cycle(count=10)
    after = bench.bus.statistics()
    carried = sum(after[name] - before[name] for name in ("bytes_in", "bytes_out")) / 10
    settings = SerialBusSettings("x", baudrate=4_000_000, fast_sync=fast, turnaround=0.0)
    computed = compute_serial_load(settings, [("legs", bench.settings)], 1.0 / PERIOD)
    # What stuffing adds depends on what is said: joints at rest say FF FF FD now and then.
    assert carried * 10 / 4e6 / PERIOD == pytest.approx(computed.total, rel=0.02)
