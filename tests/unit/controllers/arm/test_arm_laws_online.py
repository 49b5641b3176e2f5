"""A law that is stepped online makes the motion that was planned."""

import pytest
from arm_cases import ELBOW_CIRCLE, WRIST_MISS

from controllers.arm.esc import Esc, EscPaper
from controllers.arm.geometry import ArmGeometry
from controllers.arm.look_ahead import LookAhead
from controllers.arm.paths import DwellLine, TurnBack
from controllers.arm.plain import DampedLeastSquares, Inverse, ServoHalt
from controllers.arm.types import ArmReference, ArmState

PERIOD = 5e-2
REST = (0.0,) * 6
LAWS = [Inverse, DampedLeastSquares, ServoHalt, EscPaper, Esc, LookAhead]


def law_of(kind):
    return kind(kind.Settings(), ArmGeometry(), PERIOD)


@pytest.mark.parametrize("kind", LAWS, ids=lambda kind: kind.name)
@pytest.mark.parametrize(
    "path", [TurnBack(), ELBOW_CIRCLE, WRIST_MISS, DwellLine()], ids=lambda p: type(p).__name__
)
def test_online_is_as_planned(kind, path):
    if kind is LookAhead and isinstance(path, DwellLine):
        pytest.skip("look-ahead does not dwell")
    law = law_of(kind)
    plan = law.prepare(path)
    for _ in range(2):  # a second run on the same plan is the same again
        law.reset(ArmState(0.0, plan.at(0.0).positions, REST))
        for k, t in enumerate(plan.t):
            # The measured state is of no account, and neither is what the clock says.
            state = ArmState(7.0 * t, REST, REST)
            command = law.update(state, plan.at(0.0))
            assert command.positions == tuple(plan.positions[k])
            assert command.velocities == tuple(plan.velocities[k])
        command = law.update(ArmState(0.0, REST, REST), plan.at(0.0))
        assert command == (tuple(plan.positions[-1]), REST)


@pytest.mark.parametrize("kind", LAWS, ids=lambda kind: kind.name)
def test_nothing_is_planned_in_the_loop(kind, monkeypatch):
    def refused(*_):
        pytest.fail("it plans where a rig would wait for it")

    law = law_of(kind)
    plan = law.prepare(TurnBack())
    for name in ("move", "_planned", "prepare"):
        monkeypatch.setattr(kind, name, refused)
    law.reset(ArmState(0.0, REST, REST))
    for t in (*plan.t, plan.duration + PERIOD):
        law.update(ArmState(t, REST, REST), plan.at(0.0))


def test_before_its_path_a_law_goes_where_it_is_led():
    law = law_of(Esc)
    plan = law.prepare(TurnBack())
    law.reset(ArmState(0.0, REST, REST))
    led = ArmReference((0.1,) * 6, (0.2,) * 6, following=False)
    for _ in range(3):
        assert law.update(ArmState(0.0, REST, REST), led) == ((0.1,) * 6, (0.2,) * 6)
    first = law.update(ArmState(0.0, REST, REST), plan.at(0.0))
    assert first.positions == tuple(plan.positions[0])


def test_the_plan_as_a_reference():
    plan = law_of(Esc).prepare(TurnBack())
    before, during, after = plan.at(-1.0), plan.at(10 * PERIOD), plan.at(plan.duration + 1.0)
    assert before == (tuple(plan.positions[0]), REST, False, None)
    assert during == (tuple(plan.positions[10]), tuple(plan.velocities[10]), True, None)
    assert after == (tuple(plan.positions[-1]), REST, False, None)
    assert plan.t[-2] < plan.duration <= plan.t[-1] + 1e-12
