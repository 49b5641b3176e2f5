"""The stage: cues come when they are due, and the truth is looked at every millisecond."""

import itertools
import random

import pytest

from rig.faults.stage import SAMPLE, Program, Stage


class Plant:
    def __init__(self):
        self.t = 0.0

    def powered(self):
        return {}

    def truth(self):
        return (self.t,)


class World:
    """A world that only keeps the time, and how it got there."""

    def __init__(self):
        self.time = 0.0
        self.plant = Plant()

    def advance(self, t):
        assert t >= self.time
        self.time = self.plant.t = t


class Clock:
    def __init__(self):
        self.world = World()
        self._now = 0.0

    def now(self):
        return self._now

    def pause(self, duration):
        self._now += duration

    def sleep_until(self, t):
        self.world.advance(t)
        self._now = t


def make_stage():
    return Stage(Clock(), Program(lambda: None))


@pytest.mark.parametrize("seed", range(20))
def test_cues_come_in_their_order_at_their_time(seed):
    chance = random.Random(seed)
    stage, came = make_stage(), []
    times = [chance.uniform(0.0, 0.05) for _ in range(12)]
    for at in times:
        stage.cue(at, lambda at=at: came.append((at, stage.world.time)))
    t = 0.0
    while t < 0.06:
        t += chance.uniform(0.1e-3, 7e-3)
        stage.advance(t)
    assert [at for at, _ in came] == sorted(times)
    assert all(when == pytest.approx(at) for at, when in came)


def test_the_truth_is_looked_at_every_millisecond_however_long_the_program_sleeps():
    stage = make_stage()
    stage.advance(0.1)
    steps = [later - earlier for earlier, later in itertools.pairwise(stage.truth.times)]
    assert max(steps) <= SAMPLE * (1 + 1e-9)
    assert stage.truth.rows[-1] == (stage.truth.times[-1],)


def test_a_cue_may_cue_another_and_what_is_forgotten_does_not_come():
    stage, came = make_stage(), []
    stage.cue(0.01, lambda: stage.cue(0.02, lambda: came.append("second")))
    stage.cue(0.5, lambda: came.append("never"))
    stage.advance(0.1)
    stage.forget_cues()
    stage.watch_on(1.0)
    assert came == ["second"]
    assert stage.truth.times[-1] == pytest.approx(1.1, abs=2 * SAMPLE)


@pytest.mark.parametrize("seed", range(20))
def test_who_goes_another_way_leaves_no_trace_in_the_world(seed):
    """A halt more is another step of a plant's: a case alone has to be the case among others."""
    chance = random.Random(seed)
    cues = [chance.uniform(0.0, 0.05) for _ in range(9)]
    ends = list(itertools.accumulate(chance.uniform(0.1e-3, 7e-3) for _ in range(40)))
    halts = []
    for others in ([], cues):
        stage, came, ways = make_stage(), [], []
        advance = stage.world.advance
        stage.world.advance = lambda t, advance=advance, ways=ways: (ways.append(t), advance(t))
        for at in others:
            stage.cue_before(at, lambda at=at, s=stage, c=came: c.append((at, s.world.time)))
        for t in ends:
            stage.advance(t)
        assert [at for at, _ in came] == sorted(others)
        assert all(at - SAMPLE * (1 + 1e-9) <= when <= at for at, when in came)
        halts.append(ways)
    assert halts[0] == halts[1]
