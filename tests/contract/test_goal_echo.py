"""The command path of Dynamixel servos: lost setpoints, by the goals that the servos hold."""

import random

import pytest
from dynamixel_rig import dynamixel_rig
from servo_bench import PERIOD

from rig.hal import DeviceFault

GOALS = {
    "extended_position": "Goal Position (116)",
    "velocity": "Goal Velocity (104)",
}


def moving(seed, mode, joints=2, **changes):
    """Return a rig of which a drawn joint moves, how to go on, chance, and which joint."""
    chance = random.Random(seed)
    rig = dynamixel_rig(joints, mode=mode, echo=True, **changes)
    rig.start()
    axis = chance.randrange(joints)
    target = list(rig.driver.positions().value)
    speed = chance.choice((-1, 1)) * chance.uniform(0.3, 1.5)

    def go(cycles, times=1):
        for _ in range(cycles):
            target[axis] += times * (speed + 0.3 * chance.random()) * PERIOD
            rig.cycle(lambda: rig.driver.command_positions(tuple(target)))

    go(chance.randint(20, 60))
    return rig, go, chance, axis


@pytest.mark.parametrize("mode", GOALS)
@pytest.mark.parametrize("seed", range(4))
def test_a_servo_that_gets_no_setpoints_is_named_by_what_it_holds(mode, seed):
    rig, go, _, axis = moving(seed, mode, bus_settings={"fast_sync": bool(seed % 2)})
    rig.inject("arm", f"q{axis + 1}.deaf")
    before = rig.clock.now()
    with pytest.raises(DeviceFault, match=rf"q{axis + 1} \(id {axis + 1}\) does not get") as caught:
        go(60)
    assert GOALS[mode] in str(caught.value)
    assert "counts behind" in str(caught.value)
    assert rig.clock.now() - before < 0.03 + 6 * PERIOD


@pytest.mark.parametrize("seed", range(6))
def test_setpoints_that_are_lost_now_and_then_are_counted(seed):
    rig, go, chance, axis = moving(seed, "extended_position")
    assert rig.bus.statistics()["lost_setpoints"] == 0
    lost = chance.randint(1, 5)
    for _ in range(lost):
        rig.inject("arm", f"q{axis + 1}.deaf", 0.9 * PERIOD)
        go(chance.randint(5, 20))
    assert rig.bus.statistics()["lost_setpoints"] == lost


@pytest.mark.parametrize("mode", GOALS)
def test_motion_that_begins_reverses_and_ends_loses_nothing(mode):
    rig, go, chance, _ = moving(7, mode)
    for _ in range(9):
        go(chance.randint(1, 9), chance.choice((-1, 0, 1)))
    assert rig.bus.statistics()["lost_setpoints"] == 0


def test_nothing_is_expected_of_servos_that_are_released_and_energised_again():
    rig, _, _, axis = moving(8, "extended_position")
    rig.inject("arm", f"q{axis + 1}.deaf", 3 * PERIOD)
    rig.driver.set_torque_enabled(False)
    rig.run(4)
    rig.driver.set_torque_enabled(True)
    target = list(rig.driver.positions().value)
    for _ in range(20):
        target[axis] += 1e-3
        rig.cycle(lambda: rig.driver.command_positions(tuple(target)))


def test_without_echo_nothing_is_read_back_and_nothing_counted():
    rig = dynamixel_rig(2)
    rig.start()
    assert "lost_setpoints" not in rig.bus.statistics()


def test_an_echo_without_health_is_refused():
    with pytest.raises(ValueError, match="echo takes health"):
        dynamixel_rig(2, echo=True, health=False)
