"""Gains that change while a law runs: by a ramp, within bounds, and only when they are meant."""

import itertools
import math
import os
import random
from dataclasses import replace
from pathlib import Path

import pytest

from controllers.compiled import record_type
from controllers.cylinder.cascade import Cascade
from controllers.cylinder.law import PairLaw
from controllers.cylinder.pid import Pid
from controllers.cylinder.pid_friction import PidFriction
from controllers.cylinder.super_twisting import SuperTwisting
from controllers.cylinder.types import PairModel, PairReference, PairState
from rig.steering.mailbox import BOX, Mailbox
from rig.steering.online_gains import HOLD, OnlineGains
from rig.tuning.gains import values_of, with_gains

PERIOD = 1e-3
MODEL = PairModel(
    area=2.0e-4, mass=0.6, base_pressure=120e3, pressure_min=20e3, pressure_max=500e3,
    regulator_bandwidth=60.0, regulator_damping=1.0, regulator_dead_time=5e-3,
    coulomb=3.0, breakaway=4.0, stribeck_velocity=0.01, viscous=40.0,
)  # fmt: skip

LAWS = (Cascade, Pid, PidFriction, SuperTwisting)
tuned = pytest.mark.parametrize("kind", LAWS, ids=lambda kind: kind.__name__)


@pytest.fixture
def box(tmp_path):
    with Mailbox(tmp_path, create=True) as made:
        yield made


def build(kind, box, *, needs_hold=False):
    law = kind(kind.Settings(), MODEL, PERIOD)
    law.reset(PairState(0.0, 0.0, 120e3, 120e3))
    return law, OnlineGains(law, box, needs_hold=needs_hold)


def go(gains, cycles, seed=0):
    """Run some cycles of an arbitrary motion; return the commands."""
    chance = random.Random(seed)
    made = []
    for k in range(cycles):
        t = k * PERIOD
        position = 5e-3 * math.sin(3.0 * t) + chance.gauss(0.0, 1e-6)
        state = PairState(t, position, 0.13e6 + 1e4 * math.sin(9.0 * t), 0.11e6)
        made.append(gains.update(state, PairReference(position + 1e-4, 15e-3, -0.04)))
    return made


@tuned
@pytest.mark.parametrize("seed", range(5))
def test_a_gain_gets_there_by_a_ramp_and_the_law_is_the_one_of_that_gain(kind, box, seed):
    chance = random.Random(seed)
    law, gains = build(kind, box)
    which = chance.randrange(len(law.online))
    gain = law.online[which]
    start = values_of((gain,), law.settings)[gain.key]
    end = chance.uniform(gain.low, gain.high)
    ramp = chance.uniform(0.3, 1.5)
    go(gains, chance.randrange(1, 50))
    box.post(which, end, ramp)
    seen = [start]
    for _ in range(round(ramp / PERIOD) + 2):
        go(gains, 1)
        seen.append(values_of((gain,), law.settings)[gain.key])
    steps = [later - before for before, later in itertools.pairwise(seen)]
    assert seen[-1] == end
    assert all(step * (end - start) >= 0.0 for step in steps)
    assert max(map(abs, steps)) <= abs(end - start) / 50 * 1.7  # no jump
    assert gains.changed == {gain.key: end}
    # Its constants are those of a law that was made so, and its memory is what it was.
    fresh = kind(with_gains(kind.Settings(), {gain.key: end}), MODEL, PERIOD)
    for one in (law, fresh):
        one.reset(PairState(0.0, 1e-3, 130e3, 110e3))
    assert [law.update(*step) for step in steps_of(200)] == [
        fresh.update(*step) for step in steps_of(200)
    ]


def steps_of(count):
    for k in range(count):
        t = k * PERIOD
        yield PairState(t, 1e-3 * math.sin(t), 125e3, 115e3), PairReference(1e-3, 0.0, 0.0)


@tuned
def test_compiled_and_plain_change_alike(kind, tmp_path):
    made = []
    for number, compiled in enumerate((False, True)):
        folder = tmp_path / str(number)
        folder.mkdir()
        with Mailbox(folder, create=True) as box:
            law, gains = build(kind, box)
            if compiled:
                law.compile()
                law.reset(PairState(0.0, 0.0, 120e3, 120e3))
            commands = go(gains, 50)
            gain = law.online[0]
            box.post(0, gain.low + 0.4 * (gain.high - gain.low), 0.2)
            made.append(commands + go(gains, 400))
    for plain, fast in zip(*made, strict=True):
        assert plain == pytest.approx(fast, rel=1e-9)


@tuned
def test_what_a_law_remembers_stays(kind, box):
    """A change to the very same gains changes no command, to the bit."""
    law, gains = build(kind, box)
    other = kind(kind.Settings(), MODEL, PERIOD)
    other.reset(PairState(0.0, 0.0, 120e3, 120e3))
    with_box, without = go(gains, 300), []
    gain = law.online[0]
    box.post(0, values_of((gain,), law.settings)[gain.key], 0.2)
    with_box += go(gains, 400, seed=1)
    for seed, cycles in ((0, 300), (1, 400)):
        without += go(other, cycles, seed)
    assert with_box == without
    assert record_type(law.numbers) == record_type(other.numbers)


@pytest.mark.parametrize(
    ("which", "value", "ramp", "why"),
    [
        (0, 1e9, 1.0, "has to be"),
        (0, -1.0, 1.0, "has to be"),
        (0, math.nan, 1.0, "has to be"),
        (0, math.inf, 1.0, "has to be"),
        (99, 10.0, 1.0, "no gain 99"),
        (0, 50.0, math.nan, "a ramp of nan"),
    ],
)
def test_what_may_not_be_is_refused_and_said(box, which, value, ramp, why):
    law, gains = build(Cascade, box)
    before = law.settings
    box.post(which, value, ramp)
    go(gains, 100)
    assert law.settings == before
    (said,) = gains.said
    assert why in said.message
    assert said.data["accepted"] is False


def test_one_gain_at_a_time(box):
    law, gains = build(Cascade, box)
    box.post(0, 60.0, 0.5)
    go(gains, 100)
    box.post(1, 500.0, 0.5)
    go(gains, 500)
    assert [said.data["accepted"] for said in gains.said] == [True, False]
    assert gains.changed == {"position_rate": 60.0}
    assert law.settings.velocity_rate == Cascade.Settings().velocity_rate


def memory_of(folder):
    """Return the box's memory, as a file."""
    process, number = (folder / BOX).read_text().split()
    return Path(f"/proc/{process}/fd/{number}")


@pytest.mark.parametrize("seed", range(3))
def test_whatever_stands_in_the_box_only_a_whole_wish_is_heard(tmp_path, box, seed):
    """Torn in any way, and any noise: 3000 pieces of it, and no gain changes."""
    chance = random.Random(seed)
    law, gains = build(Cascade, box)
    before = law.settings
    for _ in range(3000):
        with memory_of(tmp_path).open("r+b") as stream:
            stream.seek(chance.randrange(16, 70))
            stream.write(chance.randbytes(chance.randrange(1, 40)))
        go(gains, 1)
    assert law.settings == before
    assert not gains.said


def test_a_wish_that_arrives_byte_by_byte_is_heard_once(tmp_path, box):
    law, gains = build(Cascade, box)
    box.post(0, 60.0, 0.2)
    content = memory_of(tmp_path).read_bytes()
    with memory_of(tmp_path).open("r+b", buffering=0) as stream:
        stream.seek(16)
        stream.write(bytes(64))
    go(gains, 3)
    order = list(range(16, 80))
    random.Random(1).shuffle(order)
    for place in order:
        with memory_of(tmp_path).open("r+b", buffering=0) as stream:
            stream.seek(place)
            stream.write(content[place : place + 1])
        go(gains, 1)
    go(gains, 300)
    assert [said.data["new"] for said in gains.said] == [60.0]
    assert law.settings.position_rate == 60.0


def test_on_hardware_nothing_changes_unless_somebody_holds_on(box):
    law, gains = build(Cascade, box, needs_hold=True)
    box.post(0, 60.0, 1.0)
    go(gains, 50)
    assert "nobody holds on" in gains.said[-1].message
    box.beat()
    box.post(0, 60.0, 1.0)
    for _ in range(3):  # a closed tab: it beats no longer
        go(gains, 100)
        box.beat()
    go(gains, 2000)
    assert "stays at" in gains.said[-1].message
    stayed = law.settings.position_rate
    start = Cascade.Settings().position_rate
    share = (stayed - start) / (60.0 - start)
    assert 0.3 <= share <= 0.3 + HOLD + 0.05
    box.beat()
    box.post(0, 60.0, 0.5)
    for _ in range(20):
        go(gains, 40)
        box.beat()
    assert law.settings.position_rate == 60.0


class Fixed(PairLaw):
    """A law that names no gain."""

    def _begin(self, position, difference):
        raise NotImplementedError


def test_a_law_without_such_gains_says_so():
    law = Fixed(PidFriction.Settings(), MODEL, PERIOD)
    assert not law.online
    with pytest.raises(ValueError, match="no gains that change"):
        law.retune(replace(law.settings))


def test_nobody_else_may_write_into_the_box(tmp_path, box):
    assert (tmp_path / BOX).stat().st_mode & 0o777 == 0o600
    with pytest.raises(FileExistsError):
        Mailbox(tmp_path, create=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / BOX).symlink_to(tmp_path / BOX)
    with pytest.raises(OSError, match="symbolic links"):
        Mailbox(tmp_path / "other")


@pytest.mark.parametrize("damage", ["shortened", "emptied", "removed"])
def test_nobody_takes_the_memory_away_from_under_the_loop(tmp_path, box, damage):
    """Of a file that is shortened a process that has mapped it dies at its next look."""
    _, gains = build(Cascade, box)
    with memory_of(tmp_path).open("r+b") as memory, pytest.raises(PermissionError):
        os.truncate(memory.fileno(), 0)
    if damage == "removed":
        (tmp_path / BOX).unlink()
    else:
        os.truncate(tmp_path / BOX, 3 if damage == "shortened" else 0)
    go(gains, 10)
    with pytest.raises((OSError, ValueError)):
        Mailbox(tmp_path)


@pytest.mark.parametrize("text", ["", "1", "1 2 3", "a b", "-1 0", "../../1 0", "0 0", "1" * 90])
def test_what_leads_to_no_mailbox_is_none(tmp_path, text):
    (tmp_path / BOX).write_text(text)
    with pytest.raises((OSError, ValueError)):
        Mailbox(tmp_path)


def test_the_memory_of_something_else_is_no_mailbox(tmp_path):
    with (tmp_path / "other").open("w+b") as other:
        other.write(bytes(4096))
        other.flush()
        (tmp_path / BOX).write_text(f"{os.getpid()} {other.fileno()}")
        with pytest.raises(ValueError, match="leads to no mailbox"):
            Mailbox(tmp_path)


def test_a_gain_that_began_beyond_its_bounds_comes_back_without_a_jump_and_may_return(box):
    """A profile may have it so: bounds are for those who change it."""
    beyond = 1.2 * Cascade.online[0].high
    law = Cascade(with_gains(Cascade.Settings(), {"position_rate": beyond}), MODEL, PERIOD)
    law.reset(PairState(0.0, 0.0, 120e3, 120e3))
    gains = OnlineGains(law, box, needs_hold=False)
    for end in (0.5 * beyond, beyond):
        box.post(0, end, 0.5)
        seen = [law.settings.position_rate]
        for _ in range(round(0.5 / PERIOD) + 2):
            go(gains, 1)
            seen.append(law.settings.position_rate)
        assert seen[-1] == end
        assert max(abs(b - a) for a, b in itertools.pairwise(seen)) <= 0.5 * beyond / 50 * 1.7
    box.post(0, 1.01 * beyond, 0.5)
    go(gains, 2)
    assert gains.said[-1].data["accepted"] is False
