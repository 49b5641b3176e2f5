"""What a regulator is usually off is learnt where a slow one would be off no more than that."""

import math

import pytest
from pressure_bench import LOOP, NEVER, START, Bench

from rig.mechanisms.pneumatic.alarms.answers import ChannelAnswers


@pytest.mark.parametrize("way", [-1.0, 1.0])
@pytest.mark.parametrize(("lag", "learns"), [(math.nextafter(LOOP, 0.0), True), (LOOP, False)])
def test_up_to_the_hysteresis_it_is_learnt(monkeypatch, way, lag, learns):
    bench = Bench(deviation=NEVER)
    channel = bench.watch._channels[0]
    monkeypatch.setattr(ChannelAnswers, "answer", lambda *parts: None)  # the lag stays as it is
    channel.expected = channel.prompt = 0.0
    channel.slow = way * lag
    bench.pass_by(1, ch1=1e3 - START)
    assert channel.off == 1e3
    assert (channel.usual != 0.0) is learns
