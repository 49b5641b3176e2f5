"""The command path of CiA 402 drives: lost or late setpoints, by the demand that they report."""

import random

import pytest
from servo_bench import PERIOD, cia402_rig

from drivers.sim.frame_faults import LASTING, FrameFault
from rig.hal import DeviceFault

FEEDBACK = ("velocity", "torque", "error_code", "demand")


def moving(seed, axis, **changes):
    """Return a rig in motion, how to go on, and chance."""
    chance = random.Random(seed)
    rig = cia402_rig(feedback=FEEDBACK, **changes)
    rig.start()
    target = list(rig.driver.positions().value)
    speed = chance.choice((-1, 1)) * chance.uniform(0.05, 1.5)

    def go(cycles):
        for _ in range(cycles):
            target[axis] += speed * PERIOD
            rig.cycle(lambda: rig.driver.command_positions(tuple(target)))

    go(chance.randint(20, 60))
    return rig, go, chance


def spoil(rig, axis, kind, value=None, count=LASTING):
    rig.rig.add_frame_fault("can0", FrameFault(kind, 0x201 + axis, count=count, value=value))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("kind", "value"), [("drop", None), ("delay", 0.05)])
def test_setpoints_that_do_not_arrive_in_time_name_the_drive(kind, value, seed):
    axis = seed % 2
    rig, go, _ = moving(seed, axis)
    spoil(rig, axis, kind, value)
    before = rig.clock.now()
    with pytest.raises(DeviceFault, match=rf"joint q{axis + 1} .*setpoints do not arrive.*0x6062"):
        go(60)
    assert rig.clock.now() - before < 0.03 + 6 * PERIOD


@pytest.mark.parametrize("seed", range(6))
def test_setpoints_that_are_lost_now_and_then_are_counted(seed):
    axis = seed % 2
    rig, go, chance = moving(seed, axis)
    assert rig.bus.statistics()["lost_setpoints"] == 0
    lost = 0
    for _ in range(chance.randint(1, 5)):
        spoil(rig, axis, "drop", count=1)
        go(chance.randint(5, 20))
        lost += 1
    assert rig.bus.statistics()["lost_setpoints"] == lost


def test_late_setpoints_within_the_bound_are_ridden_through():
    rig, go, _ = moving(3, 0)
    spoil(rig, 0, "delay", 0.01)
    go(100)


def test_a_demand_in_csv_is_refused():
    with pytest.raises(ValueError, match="demand is a position"):
        cia402_rig(feedback=FEEDBACK, mode="csv")


@pytest.mark.parametrize("seed", range(4))
def test_setpoints_of_somebody_else_are_heard_and_are_another_masters(seed):
    axis = seed % 2
    rig, go, _ = moving(seed, axis)
    spoil(rig, axis, "spoof")
    before = rig.clock.now()
    words = rf"can0: another master .* sends setpoints \(identifier 0x20{axis + 1}\)"
    with pytest.raises(DeviceFault, match=words):
        go(10)
    assert rig.clock.now() - before < 4 * PERIOD
