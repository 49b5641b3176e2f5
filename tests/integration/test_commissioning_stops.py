"""An acceptance test is asked to stop: its step ends, the rig is safe, and what passed is kept."""

import os
import signal

import click
import pytest
import yaml

from rig.cli import commission as command
from rig.cli import invoke
from rig.commissioning.operator import SimulatedOperator

VENTED = 1e3
"""Gauge pressure of a chamber that moves nothing, Pa."""
PRESSURES = slice(4, 6)
"""Columns of a cylinder's truth."""


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "configs" / "rigs").mkdir(parents=True)
    return tmp_path


class Interrupted(SimulatedOperator):
    """Hands that send signals when something is asked for; they keep the world they work in."""

    def __init__(self, key, numbers, kind):
        super().__init__()
        self._key, self._numbers, self._kind = key, numbers, kind
        self.world, self.came = None, False

    def do(self, task, world):
        self.world = world
        super().do(task, world)
        self._press("do", task)

    def answer(self, task):
        self._press("answer", task)
        return super().answer(task)

    def _press(self, kind, task):
        if (kind, task.key) == (self._kind, self._key):
            self.came = True
            try:
                for number in self._numbers:
                    os.kill(os.getpid(), number)
            except KeyboardInterrupt:
                if kind == "do":
                    raise
                raise click.Abort from None  # as `click.prompt` does


@pytest.fixture
def ignoring():
    """SIGINT is ignored, as `nohup` and a script's `&` have it; strays end no test."""
    before = {n: signal.signal(n, signal.SIG_IGN) for n in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("key", "kind", "numbers"),
    [
        ("emergency-stop.press", "do", [signal.SIGINT]),
        ("emergency-stop.press-energised", "do", [signal.SIGTERM]),
        ("emergency-stop.press-energised", "do", [signal.SIGINT, signal.SIGINT]),
        ("cable.pull", "do", [signal.SIGHUP]),
        ("cable.gauges", "answer", [signal.SIGHUP]),
        ("cable.gauges", "answer", [signal.SIGTERM]),
    ],
)
def test_a_signal_ends_every_step_with_the_rig_safe(
    lab, monkeypatch, capsys, ignoring, key, kind, numbers
):
    hands = Interrupted(key, numbers, kind)
    monkeypatch.setattr(command, "_operator", lambda *_: hands)
    monkeypatch.chdir(lab)
    assert invoke(["commission", "cylinder"]) == 130
    assert hands.came
    said = capsys.readouterr().err
    assert "interrupted; the rig is made safe" in said
    assert "go on with: rig commission cylinder --on virtual" in said
    record = yaml.safe_load((lab / "configs/commissioning/cylinder.yaml").read_text())
    assert all(step["passed"] for step in record["steps"].values())
    world = hands.world
    world.advance(world.time + 1.0)
    assert max(world.plant.truth()[PRESSURES]) < VENTED
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_a_second_signal_does_not_tear_what_closes_the_rig(lab, monkeypatch, capsys, ignoring):
    from rig.assembly import Rig

    ended = []
    close = Rig.close

    def torn(rig):
        rig.devices["regulators"].make_safe = press(rig.devices["regulators"].make_safe)
        close(rig)

    def press(make_safe):
        def pressed():
            os.kill(os.getpid(), signal.SIGTERM)
            os.kill(os.getpid(), signal.SIGINT)
            make_safe()
            ended.append(True)

        return pressed

    monkeypatch.setattr(Rig, "close", torn)
    monkeypatch.chdir(lab)
    assert invoke(["commission", "cylinder"]) == 130
    assert ended
    assert "go on with" in capsys.readouterr().err
