"""PDOs of the emulated nodes: configuration rules, SYNC, events, deadlines, bad lengths."""

import random
from itertools import pairwise

import pytest
from emulated_rig import AGONIST, MONITOR, REGULATORS, SETPOINT

DRAWN = random.Random(1400)
NO_OBJECT, NOT_MAPPABLE, TOO_LONG = 0x06020000, 0x06040041, 0x06040042
UNSUPPORTED, RANGE, NO_SUB = 0x06010000, 0x06090030, 0x06090011


def remap(bench, node, communication, mapping, entries, cob_id, kind=1):
    """Change a PDO in the order that the standard prescribes; return the abort codes."""
    codes = [bench.write(node, communication, 1, cob_id | 1 << 31, 4)]
    codes.append(bench.write(node, mapping, 0, 0, 1))
    for sub, entry in enumerate(entries, start=1):
        codes.append(bench.write(node, mapping, sub, entry, 4))
    codes.append(bench.write(node, mapping, 0, len(entries), 1))
    codes.append(bench.write(node, communication, 2, kind, 1))
    codes.append(bench.write(node, communication, 1, cob_id, 4))
    return [code for code in codes if code]


def test_default_parameters_are_those_of_the_standard(bench):
    bench.run()
    assert bench.read(REGULATORS, 0x1401, 1) == 0x310
    assert bench.read(REGULATORS, 0x1601, 1) == 0x64110110
    assert bench.read(REGULATORS, 0x1801, 1) == 0x40000290
    assert bench.read(REGULATORS, 0x1A01, 4) == 0x64010410
    assert bench.read(REGULATORS, 0x1601, 0) == 4
    assert bench.read(REGULATORS, 0x1802, 1) == 0xC0000390
    assert bench.read(AGONIST, 0x1A00, 1) == 0x60040020


def test_mapping_cannot_change_while_the_pdo_is_valid(bench):
    bench.run()
    assert bench.write(REGULATORS, 0x1601, 0, 0, 1) == UNSUPPORTED
    assert bench.write(REGULATORS, 0x1601, 1, 0x64110210, 4) == UNSUPPORTED


def test_mapping_cannot_change_while_its_count_is_not_zero(bench):
    bench.run()
    assert bench.write(REGULATORS, 0x1401, 1, 0x80000310, 4) == 0
    assert bench.write(REGULATORS, 0x1601, 1, 0x64110210, 4) == UNSUPPORTED


@pytest.mark.parametrize(
    ("entry", "code"),
    [
        (0x64010110, NOT_MAPPABLE),  # an input does not go into an RPDO
        (0x64430108, NOT_MAPPABLE),
        (0x64110120, NOT_MAPPABLE),  # 32 bits of an INTEGER16
        (0x99990010, NO_OBJECT),
        (0x64110910, NO_SUB),
        (0x00050008, 0),  # a dummy of eight bits
        (0x00050010, NOT_MAPPABLE),
        (0x64110210, 0),
    ],
)
def test_each_mapping_entry_is_checked_when_written(bench, entry, code):
    bench.run()
    bench.write(REGULATORS, 0x1401, 1, 0x80000310, 4)
    bench.write(REGULATORS, 0x1601, 0, 0, 1)
    assert bench.write(REGULATORS, 0x1601, 1, entry, 4) == code


def test_more_than_64_bits_are_refused(bench):
    bench.run()
    bench.write(REGULATORS, 0x1401, 1, 0x80000310, 4)
    bench.write(REGULATORS, 0x1601, 0, 0, 1)
    assert bench.write(REGULATORS, 0x1601, 5, 0x62000108, 4) == 0
    assert bench.write(REGULATORS, 0x1601, 0, 5, 1) == TOO_LONG
    assert bench.write(REGULATORS, 0x1601, 0, 9, 1) == TOO_LONG
    assert bench.write(REGULATORS, 0x1601, 0, 4, 1) == 0


@pytest.mark.parametrize("cob_id", [0x311, 0x20000310, 0x000, 0x601, 0x590, 0x701])
def test_cob_id_rules(bench, cob_id):
    bench.run()
    assert bench.write(REGULATORS, 0x1401, 1, cob_id, 4) == RANGE


@pytest.mark.parametrize("kind", [241, 251, 252, 253])
def test_transmission_types_that_are_not_offered(bench, kind):
    bench.run()
    assert bench.write(REGULATORS, 0x1801, 2, kind, 1) == RANGE


def test_inhibit_time_cannot_change_while_valid(bench):
    bench.run()
    assert bench.write(REGULATORS, 0x1801, 3, 10, 2) == RANGE


def test_one_setpoint_pdo_of_both_outputs_and_the_valve(bench):
    bench.run()
    entries = [0x64110110, 0x64110210, 0x62000108]
    assert remap(bench, REGULATORS, 0x1401, 0x1601, entries, 0x310) == []
    bench.ask("000#0110")
    bench.ask("310#FF3FFF1F01")
    assert bench.plant.setpoints == [0.0, 0.0]
    assert bench.plant.supply is False
    bench.ask("080#")
    assert bench.plant.supply is True
    assert bench.plant.setpoints == [
        pytest.approx(0x3FFF / 0x7FFF * 900e3),
        pytest.approx(0x1FFF / 0x7FFF * 900e3),
    ]


def test_synchronous_setpoints_wait_for_sync_and_asynchronous_do_not(bench):
    bench.run()
    bench.write(REGULATORS, 0x1401, 2, 1, 1)
    bench.ask("000#0110")
    bench.ask("310#FF7F000000000000")
    assert bench.plant.setpoints[0] == 0.0
    bench.ask("080#")
    assert bench.plant.setpoints[0] == pytest.approx(900e3)
    bench.write(REGULATORS, 0x1401, 2, 254, 1)
    bench.ask("310#0000000000000000")
    assert bench.plant.setpoints[0] == 0.0


def test_pdos_are_ignored_outside_operational(bench):
    bench.run()
    bench.ask("310#FF7F000000000000", "210#01", "080#")
    assert bench.plant.setpoints[0] == 0.0
    assert bench.plant.supply is False
    assert bench.run(0.1) == []


def test_short_setpoints_are_dropped_and_reported_once(bench):
    bench.start()
    assert bench.ask("310#FF7F", "310#FF7F") == ["090#1082110000000000"]
    assert bench.plant.setpoints[0] == 0.0
    assert bench.read(REGULATORS, 0x1001) == 0x11
    assert bench.read(REGULATORS, 0x1003, 1) == 0x8210
    assert bench.ask("310#FF7F000000000000") == ["090#0000000000000000"]
    assert bench.read(REGULATORS, 0x1001) == 0
    assert bench.plant.setpoints[0] == pytest.approx(900e3)


def test_sync_with_data_is_reported(bench):
    bench.start()
    assert "090#4082110000000000" in bench.ask("080#01")


@pytest.mark.parametrize("count", [1, 3, 240])
def test_transmission_on_every_nth_sync(bench, count):
    bench.run()
    bench.write(AGONIST, 0x1801, 2, count, 1)
    bench.ask("000#0120")
    answers = [bool(bench.ask("080#")) for _ in range(2 * count)]
    assert answers == [number % count == count - 1 for number in range(2 * count)]


def test_event_timer_and_inhibit_time(bench):
    bench.run()
    bench.write(AGONIST, 0x1801, 1, 0x80000000 | 0x2A0, 4)
    bench.write(AGONIST, 0x1800, 5, 20, 2)
    assert bench.ask("000#0120") == ["1A0#10270000"]
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append(t) if can_id == 0x1A0 else None
    bench.run(0.1)
    steps = {round(b - a, 9) for a, b in pairwise(times)}
    assert len(times) in (4, 5)
    assert steps == {0.02}


def test_cyclic_timer_of_the_encoder_is_the_event_timer(bench):
    bench.run()
    assert bench.write(AGONIST, 0x6200, 0, 7, 2) == 0
    assert bench.read(AGONIST, 0x1800, 5) == 7


def test_digital_input_change_is_sent_at_once(bench):
    bench.start()
    assert bench.run(0.05) == []
    bench.rig.inject("regulators", "emergency_stop")
    assert bench.run(0.005) == ["190#00"]
    bench.rig.inject("regulators", "emergency_stop", 0.0)
    assert bench.run(0.005) == ["190#01"]


def test_analogue_inputs_are_not_event_driven_until_enabled(bench):
    bench.start()
    assert bench.ask("310#0040000000000000") == []
    assert bench.run(0.02) == []
    bench.write(REGULATORS, 0x6426, 1, 100, 4)
    bench.write(REGULATORS, 0x6423, 0, 1, 1)
    bench.run(0.02)
    bench.put("310#0010000000000000")
    assert bench.run(0.02) == ["290#0010000000000000"]
    bench.put("310#5010000000000000")  # 80 counts are less than the delta of 100
    assert bench.run(0.02) == []


def test_late_setpoints_are_reported_where_a_deadline_is_set(bench):
    bench.run()
    bench.write(REGULATORS, 0x1029, 1, 1, 1)  # it stays OPERATIONAL
    bench.write(REGULATORS, 0x1401, 5, 20, 2)
    bench.ask("000#0110")
    assert bench.run(0.1) == []  # it starts with the first
    bench.ask("310#0000000000000000")
    assert bench.run(0.015) == []
    assert bench.run(0.01) == ["090#5082110000000000"]
    assert bench.ask("310#0000000000000000") == ["090#0000000000000000"]


@pytest.mark.parametrize("deadline", DRAWN.sample(range(2, 60), 3))
def test_late_setpoints_have_the_module_take_its_error_values(bench, deadline):
    bench.run()
    bench.write(REGULATORS, 0x6443, 1, 1, 1)
    bench.write(REGULATORS, 0x6443, 2, 0, 1)  # this one holds
    bench.write(REGULATORS, 0x6444, 1, 0x1000, 4)
    bench.write(REGULATORS, 0x1401, 5, deadline, 2)
    bench.ask("000#0110")
    commanded = "310#0040004000000000"
    for _ in range(5):  # none stays away for long
        bench.ask(commanded)
        assert bench.run(0.9e-3 * (deadline - 1)) == []
    before = list(bench.plant.setpoints)
    assert "090#5082110000000000" in bench.run(0.2e-3 * deadline + 2e-3)
    first, second = bench.plant.setpoints
    assert first == pytest.approx(0.25 * before[0], rel=1e-3)
    assert second == before[1]
    bench.ask(commanded)  # too late: it is in PRE-OPERATIONAL
    assert bench.plant.setpoints == [first, second]


def test_monitor_and_setpoint_scales_are_their_own(bench):
    bench.run()
    bench.ask("610#2B11640100400000")
    pressure = 0x4000 / 0x7FFF * 900e3
    assert bench.plant.setpoints[0] == pytest.approx(pressure)
    # the monitor's 1 … 5 V are converted on the same 0x7FFF counts
    assert bench.read(REGULATORS, 0x6401, 1) == 0x4000
    assert SETPOINT.electrical != MONITOR.electrical


def test_inhibit_time_spaces_the_frames_of_a_busy_input(bench):
    bench.run()
    bench.write(REGULATORS, 0x1800, 1, 0x80000190, 4)
    assert bench.write(REGULATORS, 0x1800, 3, 200, 2) == 0  # 20 ms in 100 us
    bench.write(REGULATORS, 0x1800, 1, 0x190, 4)
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append(t) if can_id == 0x190 else None
    bench.ask("000#0110")
    for tick in range(50):
        bench.rig.inject("regulators", "emergency_stop", float(tick % 2 == 0))
        bench.run(0.002)
    assert len(times) > 3
    assert min(b - a for a, b in pairwise(times)) >= 0.02 - 1e-9


def test_inhibit_time_spaces_emergencies(bench):
    bench.run()
    bench.write(REGULATORS, 0x1015, 0, 100, 2)  # 10 ms
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append(t)
    for code in (0x1000, 0x2000, 0x3000):
        bench.rig.inject("regulators", "emergency", float(code))
    bench.run(0.1)
    assert times == pytest.approx([times[0] + delay for delay in (0.0, 0.01, 0.02)])
