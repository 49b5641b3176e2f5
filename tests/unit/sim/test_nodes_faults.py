"""Faults of nodes, frames and buses, from tests and from a schedule."""

from itertools import pairwise

import pytest
from emulated_rig import AGONIST, REGULATORS, Bench

from drivers.sim.frame_faults import FrameFault
from rig.config.simulation_models import FaultSpec


def on_sync(bench):
    bench.run()
    bench.ask("000#0120")
    bench.run(0.01)


def test_unknown_faults_and_devices_are_named(bench):
    with pytest.raises(ValueError, match=r"regulators: no fault 'explode'; known are .*wire_break"):
        bench.rig.inject("regulators", "explode")
    with pytest.raises(ValueError, match=r"no device 'arm'.*agonist"):
        bench.rig.inject("arm", "silent")
    with pytest.raises(ValueError, match=r"bus can0: no fault"):
        bench.rig.inject("can0", "silent")
    with pytest.raises(ValueError, match=r"whole number in 0 … 1"):
        bench.rig.inject("regulators", "wire_break", 2.0)


def test_silent_node_comes_back_with_its_settings(bench):
    bench.run()
    bench.write(REGULATORS, 0x6444, 1, 5, 4)
    bench.rig.inject("regulators", "silent", 0.1)
    assert bench.ask("610#4000100000000000") == []
    bench.run(0.2)
    assert bench.read(REGULATORS, 0x6444, 1) == 5


def test_rebooted_node_announces_itself_and_has_forgotten(bench):
    bench.run()
    bench.write(REGULATORS, 0x6444, 1, 5, 4)
    bench.rig.inject("regulators", "reboot")
    assert bench.run() == ["710#00"]
    assert bench.read(REGULATORS, 0x6444, 1) == 0


def test_wrong_state(bench):
    bench.run()
    bench.write(REGULATORS, 0x1017, 0, 500, 2)
    bench.ask("000#0110")
    bench.rig.inject("regulators", "wrong_state", 127.0)
    assert bench.run() == ["710#7F"]


def test_wrong_device_type_survives_a_reset(bench):
    bench.run()
    bench.rig.inject("agonist", "wrong_device_type", float(0x00020192))
    bench.ask("000#8120")
    assert bench.read(AGONIST, 0x1000) == 0x00020192
    bench.rig.inject("agonist", "repair")
    assert bench.read(AGONIST, 0x1000) == 0x00080196


def test_one_object_refuses(bench):
    bench.run()
    bench.rig.inject("regulators", "sdo_abort", float(0x644301))
    assert bench.write(REGULATORS, 0x6443, 1, 1, 1) == 0x08000000
    assert bench.write(REGULATORS, 0x6443, 2, 1, 1) == 0


def test_sdo_silence(bench):
    bench.run()
    bench.rig.inject("regulators", "sdo_silent", 0.05)
    assert bench.ask("610#4000100000000000") == []
    bench.run(0.1)
    assert bench.read(REGULATORS, 0x1001) == 0


def test_emergency_of_any_code(bench):
    bench.run()
    bench.rig.inject("regulators", "emergency", float(0x3120))
    assert bench.run() == ["090#2031010000000000"]
    assert bench.read(REGULATORS, 0x1003, 1) == 0x3120


def test_broken_monitor_wire_reads_less_than_any_pressure(bench):
    bench.run()
    bench.rig.inject("regulators", "wire_break", 1.0)
    assert bench.read(REGULATORS, 0x6401, 1) == 0
    raw = bench.read(REGULATORS, 0x6401, 2)
    assert raw - 0x10000 == round(-0x7FFF / 4)  # 0 V on a scale of 1 … 5 V


def test_stuck_output_keeps_its_pressure(bench):
    bench.run()
    bench.ask("610#2B11640100400000")
    before = bench.plant.setpoints[0]
    bench.rig.inject("regulators", "output_stuck", 0.0)
    bench.ask("610#2B11640100000000")
    assert bench.plant.setpoints[0] == before


@pytest.mark.parametrize(
    ("fault", "frames"),
    [
        (FrameFault("drop", 0x2A0), [[], ["2A0#10270000"]]),
        (FrameFault("drop", 0x2A0, after=1, count=1), [["2A0#10270000"], []]),
        (FrameFault("duplicate", 0x2A0), [["2A0#10270000"] * 2, ["2A0#10270000"]]),
        (FrameFault("truncate", 0x2A0, value=2), [["2A0#1027"], ["2A0#10270000"]]),
        (FrameFault("corrupt", 0x2A0, value=3), [["2A0#102700FF"], ["2A0#10270000"]]),
        (FrameFault("delay", 0x2A0, value=0.001), [[], ["2A0#10270000"] * 2]),
        (FrameFault("drop", 0x080), [[], ["2A0#10270000"]]),
        (FrameFault("truncate", 0x2A1, value=2), [["2A0#10270000"]] * 2),
    ],
)
def test_frame_faults(bench, fault, frames):
    on_sync(bench)
    bench.rig.add_frame_fault("can0", fault)
    assert [bench.ask("080#"), bench.ask("080#")] == frames
    assert bench.ask("080#") == ["2A0#10270000"]


def test_frames_of_a_node_by_name(bench):
    on_sync(bench)
    bench.rig.inject("agonist", "drop_frames", 3.0)
    assert [len(bench.ask("080#")) for _ in range(5)] == [0, 0, 0, 1, 1]
    with pytest.raises(ValueError, match=r"drop_frames does not take 0.5"):
        bench.rig.inject("agonist", "drop_frames", 0.5)


def test_foreign_frames(bench):
    bench.run()
    bench.rig.inject("can0", "foreign_frame", float(0x123))
    bench.side.send_foreign(0x0FFFFFFE, b"\x01")
    assert bench.run() == ["123#0000000000000000", "FFFFFFE#01"]


def test_losses_are_the_same_for_the_same_seed():
    def run(seed):
        bench = Bench(seed=seed)
        bench.start()
        bench.rig.inject("can0", "frame_loss", 0.3)
        return [len(bench.ask("080#")) for _ in range(300)]

    assert run(1) == run(1) != run(2)
    # a SYNC that arrives brings two frames, each with the same chance of getting through
    assert sum(run(1)) == pytest.approx(300 * 2 * 0.7 * 0.7, rel=0.1)


def test_schedule_acts_at_its_time_whatever_the_step():
    for step in (0.001, 0.004, 0.5):
        bench = Bench(faults=(FaultSpec(0.0303, "agonist", "emergency", 4096.0),))
        times = []
        bench.side.monitor = lambda t, can_id, data, times=times: times.append((t, can_id))
        while bench.rig.time < 1.0:
            bench.run(step)
        assert (0.0303, 0x0A0) in times


def test_schedule_names_a_device_that_is_not_there():
    with pytest.raises(ValueError, match=r"no device 'legs'"):
        Bench(faults=(FaultSpec(1.0, "legs", "silent"),))
    with pytest.raises(ValueError, match=r"can0: no fault 'silent'; known are frame_loss"):
        Bench(faults=(FaultSpec(1.0, "can0", "silent"),))


def test_scheduled_fault_lasts_from_its_time():
    bench = Bench(faults=(FaultSpec(0.5, "agonist", "silent", 0.1),))
    bench.run()
    bench.write(AGONIST, 0x1017, 0, 10, 2)
    times = []
    bench.side.monitor = lambda t, can_id, data: times.append(t)
    bench.run(1.0)
    gap = max(b - a for a, b in pairwise(times))
    assert gap == pytest.approx(0.11, abs=0.011)
    assert not [t for t in times if 0.5 <= t < 0.6]


def test_frames_arrive_after_the_latency_however_time_is_cut():
    for step in (0.0001, 0.00035, 0.01):
        bench = Bench(latency=0.0007)
        bench.run()
        start = bench.rig.time
        times = []
        bench.side.monitor = lambda t, can_id, data, times=times: times.append(t)
        bench.put("610#4000100000000000")
        while bench.rig.time < start + 0.01:
            bench.run(step)
        assert times == pytest.approx([start + 0.0007] * 2)
