"""An encoder that lies to the drive whose loop it closes: the joint truly moves wrongly.

On every kind of drive. What can be seen is seen within 50 ms of motion. A drive that can follow
velocities instead holds the joint by them; of other drives it is let go of, since their own loops
would run away.
"""

import math
import random

import pytest
from dynamixel_rig import dynamixel_rig
from servo_bench import PERIOD, cia402_rig, odrive_rig

from rig.hal import DeviceFault

RIGS = {"cia402": cia402_rig, "odrive": odrive_rig, "dynamixel": dynamixel_rig}
SEEN_WITHIN = 0.05


def moving(kind, seed, **changes):
    """Return a rig whose joints move, one of them, the speed, and how to go on."""
    chance = random.Random(f"{kind} {seed}")
    rig = RIGS[kind](**changes)
    rig.start()
    axis = chance.randrange(2)
    speed = chance.choice((-1, 1)) * chance.uniform(0.3, 1.5)
    target = list(rig.driver.positions().value)

    def go(cycles):
        for _ in range(cycles):
            target[axis] += speed * PERIOD
            rig.cycle(lambda: rig.driver.command_positions(tuple(target)))

    go(chance.randint(20, 60))
    return rig, axis, speed, go, target


def lie(rig, kind, axis, how, value=None):
    if kind == "dynamixel":
        rig.inject("arm", f"q{axis + 1}.encoder_{how}", value)
    else:
        rig.inject(f"arm.q{axis + 1}", f"encoder_{how}", value)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("how", ["frozen", "mirrored"])
@pytest.mark.parametrize("kind", RIGS)
def test_it_is_named_within_50_ms_of_motion_and_its_loop_opened(kind, how, seed):
    rig, axis, _, go, _ = moving(kind, seed)
    lie(rig, kind, axis, how)
    before = rig.clock.now()
    with pytest.raises(DeviceFault, match=rf"q{axis + 1}.*encoder is {how}"):
        go(100)
    assert rig.clock.now() - before <= SEEN_WITHIN + PERIOD
    rig.safe_cycles(10)
    held = rig.plant.angles[axis]
    assert rig.plant.powered[axis] == (kind == "cia402")
    assert rig.plant.powered[1 - axis]
    rig.safe_cycles(20)
    assert rig.plant.angles[axis] == pytest.approx(held, abs=1e-3)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", RIGS)
def test_a_zero_that_wanders_is_seen_before_the_joint_has_gone_far(kind, seed):
    """At rest, where the loop moves the joint along and the position stays, as a frozen one."""
    rig, axis, _, _, target = moving(kind, seed)
    chance = random.Random(f"drift {kind} {seed}")
    rate = chance.choice((-1.0, 1.0)) * chance.uniform(0.07, 0.2)
    for _ in range(40):
        rig.cycle(lambda: rig.driver.command_positions(tuple(target)))
    before = rig.plant.angles[axis]
    lie(rig, kind, axis, "drift", rate)
    with pytest.raises(DeviceFault, match=rf"q{axis + 1}.*encoder (wanders|is frozen)"):
        for _ in range(int(0.6 / PERIOD)):
            rig.cycle(lambda: rig.driver.command_positions(tuple(target)))
    assert abs(rig.plant.angles[axis] - before) <= 0.08


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", RIGS)
def test_a_sound_encoder_is_not_blamed(kind, seed):
    rig, _, _, go, target = moving(kind, seed)
    go(int(0.5 / PERIOD))
    for _ in range(int(1.0 / PERIOD)):
        rig.cycle(lambda: rig.driver.command_positions(tuple(target)))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["cia402", "dynamixel"])
def test_a_joint_whose_encoder_jumps_hardly_moves(kind, seed):
    rig, axis, _, go, _ = moving(kind, seed)
    chance = random.Random(f"jump {kind} {seed}")
    size = chance.choice((-1.0, 1.0)) * math.exp(chance.uniform(math.log(0.1), math.log(0.8)))
    before = rig.plant.angles[axis]
    lie(rig, kind, axis, "jump", size)
    with pytest.raises(DeviceFault, match=rf"q{axis + 1}.*jumped"):
        go(5)
    rig.safe_cycles(40)
    fastest, _ = rig.plant.caps[axis]
    # Seen, told, obeyed, and confirmed where the zero has to be moved; then a lag.
    assert abs(rig.plant.angles[axis] - before) <= fastest * (5 * PERIOD + 0.01)
    assert rig.plant.powered[axis]
    assert rig.driver.unsafe(rig.clock.now()) == ""


@pytest.mark.parametrize("how", ["frozen", "mirrored", "jump"])
def test_a_drive_that_does_not_know_velocities_is_not_asked_to(how):
    rig, axis, _, go, _ = moving("cia402", 3)
    for drive in rig.driver.drives:
        drive._stops_by_velocity = False
    lie(rig, "cia402", axis, how)
    with pytest.raises(DeviceFault):
        go(100)
    rig.safe_cycles(10)
    assert rig.plant.powered[axis] == (how == "jump")


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("how", "value"), [("drift", 0.08), ("drift", -0.08), ("scale", 1.3)])
@pytest.mark.parametrize("kind", RIGS)
def test_a_drift_and_a_scale_lead_the_joint_astray(kind, how, value, seed):
    rig, axis, speed, go, target = moving(kind, seed)
    true = rig.plant.angles[axis]
    begun = target[axis]
    lie(rig, kind, axis, how, value)
    go(60)
    way = target[axis] - begun
    wanted = way - value * 60 * PERIOD if how == "drift" else way / value
    assert rig.plant.angles[axis] - true == pytest.approx(wanted, abs=0.15 * abs(speed))
    assert abs(rig.plant.angles[axis] - true - way) > 0.5 * abs(wanted - way)
    assert rig.driver.positions().value[axis] == pytest.approx(target[axis], abs=0.1)


@pytest.mark.parametrize("kind", RIGS)
def test_sound_encoders_are_believed(kind):
    for seed in range(5):
        _, _, _, go, _ = moving(kind, seed)
        go(60)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", RIGS)
def test_one_that_scatters_shakes_its_joint_by_as_much_and_stays_where_it_is(kind, seed):
    rig, axis, _, go, target = moving(kind, seed)
    size = random.Random(seed).uniform(5e-4, 2e-3)
    lie(rig, kind, axis, "noisy", size)
    off = []
    for _ in range(200):
        go(1)
        off.append(rig.driver.positions().value[axis] - rig.plant.angles[axis])
    mean = sum(off) / len(off)
    rms = math.sqrt(sum((x - mean) ** 2 for x in off) / len(off))
    assert 0.8 * size < rms < 3.0 * size + 2e-3
    assert abs(rig.plant.angles[axis] - target[axis]) < 0.05
