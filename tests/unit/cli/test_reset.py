"""`rig reset`: what clears a latched fault, and what does not."""

import contextlib
import json
import random
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from rig.assembly import Backend
from rig.cli.reset import reset

PERIOD = 0.02


class FakeRig:
    """A rig whose emergency stop is open between some times; `looks` counts who looked when."""

    def __init__(self, open_from=None, open_until=None, *, has_contact=True):
        self.time = 50.0
        self.looks = []
        self.clock = self
        self.mechanism = SimpleNamespace(stop_input=lambda: self if has_contact else None)
        self._open = (open_from, open_until)
        self.watched = 0

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.time = max(self.time, t)

    @contextlib.contextmanager
    def watching_stop(self):
        self.watched += 1
        yield self.is_pressed

    def is_pressed(self):
        since = self.time - 50.0
        self.looks.append(since)
        start, end = self._open
        if start is None:
            return end  # what it says all the time
        return start <= since < (end if end is not None else 1e9)


class FakeLatch:
    def __init__(self, reason):
        self.name = None
        self.cleared = 0
        self._reason = reason

    def __call__(self, name):
        self.name = name
        return self

    def reason(self):
        return self._reason

    def clear(self):
        self.cleared += 1


@pytest.fixture
def bench(monkeypatch):
    """Return what resets a fake rig: its exit code, what it said, and the latch."""

    def run(made, *words, reason="it fell"):
        latch, built = FakeLatch(reason), []
        monkeypatch.setattr("rig.experiment.fault_latch.FaultLatch", latch)

        def build(profile, backend, on=None):
            built.append((profile, backend, on))
            return made

        monkeypatch.setattr("rig.assembly.build_rig", build)
        monkeypatch.setattr(
            "rig.config.load_profile",
            lambda rig, registry, overrides, configs: SimpleNamespace(
                name=f"the {rig}", overrides=overrides, configs=configs
            ),
        )
        result = CliRunner().invoke(reset, ["lab-rig", *words], standalone_mode=False)
        if "--json" not in words:
            assert result.stdout == ""  # it is all talk
        return result, latch, built

    return run


def test_a_rig_without_a_fault_is_not_touched(bench):
    result, latch, built = bench(FakeRig(), reason=None)
    assert result.return_value == 0
    assert "the lab-rig has no latched fault" in result.stderr
    assert (built, latch.cleared, latch.name) == ([], 0, "the lab-rig")


@pytest.mark.parametrize("seed", range(4))
def test_a_stop_that_is_pressed_and_released_resets(bench, seed):
    chance = random.Random(seed)
    start = chance.uniform(0.0, 2.0)
    end = start + chance.uniform(2 * PERIOD, 3.0)
    made = FakeRig(start, end)
    result, latch, built = bench(made, "--wait", "10")
    assert result.return_value == 0
    said = result.stderr
    for words in ("the lab-rig is latched: it fell", "press the emergency stop, and release it"):
        assert words in said
    assert "the lab-rig is reset" in said
    assert latch.cleared == 1
    assert made.watched == 1
    assert end <= made.looks[-1] <= end + PERIOD + 1e-9  # and not before it was let go of
    assert all(
        b - a == pytest.approx(PERIOD) for a, b in zip(made.looks, made.looks[1:], strict=False)
    )
    ((_, backend, on),) = built
    assert (backend, on) == (Backend.HARDWARE, None)


@pytest.mark.parametrize(
    ("contact", "words", "reason", "code"),
    [
        ((None, None), (), None, 0),
        ((0.5, 1.0), (), "it fell", 0),
        ((None, False), ("--wait", "1"), "it fell", 3),
        (None, ("--yes", "the lab-rig"), "it fell", 0),
        (None, ("--yes", "another"), "it fell", 2),
    ],
    ids=["no fault", "pressed", "not pressed", "named", "another rig"],
)
def test_what_came_of_it_is_printed_as_json(bench, contact, words, reason, code):
    made = FakeRig(has_contact=False) if contact is None else FakeRig(*contact)
    result, latch, _ = bench(made, *words, "--json", reason=reason)
    assert result.return_value == code
    assert json.loads(result.stdout) == {
        "rig": "the lab-rig",
        "was_latched": reason,
        "is_latched": code != 0,
    }
    assert latch.cleared == (reason is not None and code == 0)
    assert result.stderr  # words are on stderr all the same


@pytest.mark.parametrize(
    ("opens", "told"),
    [
        ((None, False), "its circuit was closed all the time"),
        ((None, True), "nobody has released it"),
        ((None, None), "the device that reads it has told nothing"),
        ((0.5,), "nobody has released it"),
        ((20.0, 21.0), "its circuit was closed all the time"),
    ],
    ids=["never pressed", "always open", "never heard", "never released", "too late"],
)
def test_nothing_else_resets(bench, opens, told):
    made = FakeRig(*opens)
    result, latch, _ = bench(made, "--wait", "3")
    assert result.return_value == 3
    assert "the emergency stop was not pressed and released within 3 s" in result.stderr
    assert told in result.stderr
    assert latch.cleared == 0
    assert 3.0 - 2 * PERIOD <= made.looks[-1] < 3.0
    assert "is reset" not in result.stderr


def test_a_release_at_the_end_of_the_time_is_too_late(bench):
    made = FakeRig(0.0, 2.0)
    made.sleep_until = lambda t: setattr(made, "time", 52.0)
    result, latch, _ = bench(made, "--wait", "2")
    assert (result.return_value, latch.cleared) == (3, 0)
    assert made.looks == [0.0]


def test_a_contact_that_is_not_heard_for_a_while_is_no_release(bench):
    """Open, silent, closed: pressed and released; silent, closed: nobody has pressed it."""
    made = FakeRig()
    answers = iter([None, False, True, None, None, False])
    made.is_pressed = lambda: next(answers)
    result, latch, _ = bench(made)
    assert (result.return_value, latch.cleared) == (0, 1)
    assert next(answers, "none left") == "none left"


def test_it_waits_a_minute_if_nobody_says_how_long(bench):
    made = FakeRig(None, False)
    result, _, _ = bench(made)
    assert "within 60 s" in result.stderr
    assert 60.0 - 2 * PERIOD <= made.looks[-1] < 60.0


@pytest.mark.parametrize(("yes", "code"), [("the lab-rig", 0), ("another", 2)])
def test_a_rig_without_a_contact_asks_for_its_name(bench, yes, code):
    made = FakeRig(has_contact=False)
    result, latch, _ = bench(made, "--yes", yes)
    assert result.return_value == code
    assert latch.cleared == (code == 0)
    assert made.looks == []


def test_an_interface_is_passed_on_with_the_profile_as_it_was_asked_for(bench, tmp_path):
    (tmp_path / "rigs").mkdir()
    made = FakeRig(has_contact=False)
    words = ("--on", "socketcan:can7", "--set", "a.b=1", "--configs", str(tmp_path))
    result, _, built = bench(made, *words, "--yes", "the lab-rig")
    assert result.return_value == 0, result.exception
    ((profile, backend, on),) = built
    assert backend is Backend.HARDWARE
    assert on == "socketcan:can7"
    assert profile.overrides == ("a.b=1",)
    assert profile.configs == (tmp_path,)


def test_whoever_does_not_confirm_resets_nothing(bench, monkeypatch):
    result, latch, _ = bench(FakeRig(has_contact=False), "--yes", "another")
    assert "--yes another: this is the rig the lab-rig" in result.stderr
    monkeypatch.setattr("rig.cli.confirm.confirm", lambda name, yes: False)
    result, latch, _ = bench(FakeRig(has_contact=False))
    assert (result.return_value, latch.cleared) == (2, 0)


def test_a_contact_that_was_closed_and_falls_silent_was_heard(bench):
    made = FakeRig()
    made.is_pressed = lambda: None if made.time > 51.0 else False
    result, _, _ = bench(made, "--wait", "3")
    assert "its circuit was closed all the time" in result.stderr


@pytest.mark.parametrize("reason", [None, "it fell"])
@pytest.mark.parametrize("presses", [True, False])
def test_in_simulation_it_is_rehearsed_and_resets_nothing(bench, monkeypatch, reason, presses):
    made, acted, asked = FakeRig(None, False), [], []

    class Hands:
        def act(self, since):
            acted.append(since)
            made._open = (0.0, 0.5)

    def hands_at(rig, on):
        asked.append((rig, on))
        return Hands() if presses else None

    monkeypatch.setattr("rig.cli.stop_hands.hands_at", hands_at)
    result, latch, ((_, backend, on),) = bench(made, "--on", "sim", "--wait", "3", reason=reason)
    assert (result.return_value, latch.cleared) == (0 if presses else 3, 0)
    assert (backend, on, asked) == (Backend.SIM, None, [(made, None)])
    assert acted == (pytest.approx(made.looks) if presses else [])
    held = "it has no latched fault" if reason is None else "it stays latched"
    said = f"a rehearsal on sim: on hardware this resets the lab-rig; {held}"
    assert (said in result.stderr) == presses
    made.time = 50.0
    result, _, _ = bench(made, "--on", "sim", "--wait", "3", "--json", reason=reason)
    assert json.loads(result.stdout) == {
        "rig": "the lab-rig",
        "was_latched": reason,
        "is_latched": reason is not None,
        "rehearsed": presses,
    }
