"""State machine, heartbeats both ways, and what outputs do when the master falls silent."""

import pytest
from emulated_rig import AGONIST, ANTAGONIST, REGULATORS

PRESSURE = 0x4000 / 0x7FFF * 900e3
MASTER = 0x7F


def test_boot_up_messages_come_first(bench):
    assert bench.run() == ["710#00", "720#00", "721#00"]
    assert bench.run(10.0) == []


@pytest.mark.parametrize(
    ("command", "heartbeat"), [("01", "05"), ("02", "04"), ("80", "7F"), ("81", "00"), ("82", "00")]
)
def test_commands_for_one_node(bench, command, heartbeat):
    bench.run()
    bench.write(REGULATORS, 0x1017, 0, 100, 2)
    bench.ask("000#0110" if command == "80" else "000#0210")
    frames = bench.ask(f"000#{command}10")
    expected = [] if command == "02" else [f"710#{heartbeat}"]  # it was stopped already
    assert frames[:1] == expected


def test_broadcast_reaches_all_and_other_nodes_are_not_meant(bench):
    bench.run()
    for node in (REGULATORS, AGONIST, ANTAGONIST):
        bench.write(node, 0x1017, 0, 1000, 2)
    assert bench.ask("000#0100")[:3] and bench.regulators.state == 5
    bench.ask("000#0220")
    states = [node.state for node in bench.side.nodes]
    assert states == [5, 4, 5]


@pytest.mark.parametrize("frame", ["000#01", "000#010000", "000#", "000#FF00", "000#0011"])
def test_malformed_commands_are_ignored(bench, frame):
    bench.run()
    bench.ask(frame)
    assert {node.state for node in bench.side.nodes} == {0x7F}


def test_heartbeat_period_does_not_drift(bench):
    bench.run()
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append(t) if can_id == 0x710 else None
    bench.write(REGULATORS, 0x1017, 0, 50, 2)
    for _ in range(333):
        bench.run(0.003)
    assert times[1:] == pytest.approx([times[0] + 0.05 * k for k in range(1, len(times))])
    assert len(times) == 20


def arm(bench, behaviour=0, timeout=150):
    """Set what a master sets before it starts a regulator node, then start it."""
    bench.run()
    assert bench.write(REGULATORS, 0x1016, 1, MASTER << 16 | timeout, 4) == 0
    assert bench.write(REGULATORS, 0x1029, 1, behaviour, 1) == 0
    bench.ask("77F#05")
    bench.ask("000#0110")
    bench.ask("210#01", "310#0040004000000000")
    assert bench.plant.setpoints == [pytest.approx(PRESSURE)] * 2
    assert bench.plant.supply is True


@pytest.mark.parametrize(("behaviour", "state"), [(0, 0x7F), (2, 0x04)])
def test_outputs_vent_when_the_master_falls_silent(bench, behaviour, state):
    arm(bench, behaviour)
    bench.write(REGULATORS, 0x1017, 0, 1000, 2)
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append((t, can_id, data))
    bench.ask("77F#05")
    heard = times[0][0]
    times.clear()
    bench.run(0.149)
    assert bench.plant.setpoints == [pytest.approx(PRESSURE)] * 2
    assert bench.run(0.01) == [
        f"090#308111{MASTER:02X}00000000",
        f"710#{state:02X}",
    ]
    assert [t for t, _, _ in times] == pytest.approx([heard + 0.15] * 2)
    assert bench.plant.setpoints == [0.0, 0.0]
    assert bench.plant.supply is False


def test_behaviour_1_only_reports(bench):
    arm(bench, behaviour=1)
    assert bench.run(0.2) == [f"090#308111{MASTER:02X}00000000"]
    assert bench.plant.setpoints == [pytest.approx(PRESSURE)] * 2
    assert bench.regulators.state == 5


def test_loss_is_reported_once_and_its_end_as_well(bench):
    arm(bench)
    assert len(bench.run(5.0)) == 1
    assert bench.ask("77F#05") == ["090#0000000000000000"]
    assert bench.regulators.state == 0x7F  # it does not start by itself


def test_monitoring_starts_with_the_first_heartbeat(bench):
    bench.run()
    bench.write(REGULATORS, 0x1016, 1, MASTER << 16 | 150, 4)
    assert bench.run(10.0) == []


def test_master_that_restarts_counts_as_lost(bench):
    arm(bench)
    assert bench.ask("77F#00") == [f"090#308111{MASTER:02X}00000000"]
    assert bench.plant.setpoints == [0.0, 0.0]


def test_one_node_is_not_watched_twice(bench):
    bench.run()
    assert bench.write(REGULATORS, 0x1016, 1, MASTER << 16 | 150, 4) == 0
    assert bench.write(REGULATORS, 0x1016, 2, MASTER << 16 | 300, 4) == 0x06040043


def test_nodes_hear_each_other(bench):
    bench.run()
    bench.write(REGULATORS, 0x1016, 1, AGONIST << 16 | 100, 4)
    bench.write(AGONIST, 0x1017, 0, 40, 2)
    assert not [frame for frame in bench.run(1.0) if frame.startswith("090")]
    bench.rig.inject("agonist", "heartbeat_silent", 0.5)
    frames = [frame for frame in bench.run(1.0) if frame.startswith("090")]
    assert frames == ["090#3081112000000000", "090#0000000000000000"]


@pytest.mark.parametrize("command", ["02", "80", "81", "82"])
def test_every_way_out_of_operational_takes_the_error_values(bench, command):
    arm(bench)
    bench.ask(f"000#{command}10")
    assert bench.plant.setpoints == [0.0, 0.0]
    assert bench.plant.supply is False


def test_error_modes_and_values_are_per_channel(bench):
    bench.run()
    bench.write(REGULATORS, 0x6443, 1, 0, 1)  # hold
    bench.write(REGULATORS, 0x6444, 2, 0x2000, 4)
    bench.write(REGULATORS, 0x6206, 1, 0, 1)  # hold
    bench.ask("000#0110", "210#01", "310#0040004000000000", "000#8010")
    bench.run()
    assert bench.plant.setpoints == [
        pytest.approx(PRESSURE),
        pytest.approx(0x2000 / 0x7FFF * 900e3),
    ]
    assert bench.plant.supply is True


def test_the_last_command_comes_back_with_operational(bench):
    arm(bench)
    bench.ask("000#8010")
    assert bench.plant.setpoints == [0.0, 0.0]
    bench.ask("000#0110")
    assert bench.plant.setpoints == [pytest.approx(PRESSURE)] * 2


def test_reset_of_communication_keeps_the_application_objects(bench):
    bench.run()
    bench.write(REGULATORS, 0x6444, 1, 77, 4)
    bench.write(REGULATORS, 0x1017, 0, 100, 2)
    bench.ask("000#8210")
    assert bench.read(REGULATORS, 0x6444, 1) == 77
    assert bench.read(REGULATORS, 0x1017) == 0
    bench.ask("000#8110")
    assert bench.read(REGULATORS, 0x6444, 1) == 0


def test_boot_up_of_a_master_that_was_not_there_yet_is_no_loss(bench):
    bench.run()
    bench.write(REGULATORS, 0x1016, 1, MASTER << 16 | 150, 4)
    assert bench.ask("77F#00") == []


def test_digital_error_value_is_masked_by_its_mode(bench):
    bench.run()
    bench.write(REGULATORS, 0x6207, 1, 0xFF, 1)
    bench.write(REGULATORS, 0x6206, 1, 0xFE, 1)
    bench.ask("000#0110", "000#8010")
    assert bench.plant.supply is False  # the valve's bit holds
    bench.write(REGULATORS, 0x6206, 1, 0x01, 1)
    bench.ask("000#0110", "000#8010")
    assert bench.plant.supply is True


def test_a_node_off_the_bus_acts_on_nothing_and_vents(bench):
    arm(bench)
    bench.rig.inject("regulators", "silent", 1.0)
    for _ in range(30):
        bench.ask("77F#05", "310#FF7F000000000000")
        assert bench.plant.setpoints[0] < 500e3
        bench.run(0.01)
    assert bench.plant.setpoints == [0.0, 0.0]
