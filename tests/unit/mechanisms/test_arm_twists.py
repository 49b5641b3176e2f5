"""Twists that are heard while the arm moves: silence, nonsense, the tool's frame, a gamepad."""

import math
import os
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from controllers.arm.esc import Esc, EscSettings
from controllers.arm.geometry import ArmGeometry
from controllers.arm.online.braking import periods_to_rest, slowed_to_rest
from controllers.arm.online.commands import ArmTwists, TwistRows
from controllers.arm.types import AT_REST, ArmReference
from controllers.motion import InfeasibleMotion
from rig.hal import SafetyError
from rig.mechanisms.arm.gamepad import GamepadTwists
from rig.mechanisms.arm.twist_facts import facts_of_twists
from rig.mechanisms.arm.twists import HeardTwists

HERE = ArmReference((0.0, 0.3, 1.5, 0.0, 0.5, 0.0), AT_REST, True)
AHEAD = (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
PERIOD = 5e-3


class Told(ArmTwists):
    """Says what a function of time says."""

    __slots__ = ("say",)

    def twist(self, t):
        return self.say(t)


def heard(say, **settings):
    twists = Told(**settings)
    object.__setattr__(twists, "say", say)
    motion = HeardTwists(twists, ArmGeometry(), PERIOD)
    motion.attach({})
    return motion


def followed(motion, until):
    """Return the asked twists cycle by cycle, and the notes with their instants."""
    asked, notes = {}, []
    for k in range(1, round(until / PERIOD) + 1):
        t = k * PERIOD
        notes += [(t, note) for note in motion.see(t, None, HERE)]
        asked[round(t, 6)] = motion.at(t).twist
    return asked, notes


def test_silence_stops_the_hand_and_says_so():
    motion = heard(lambda t: AHEAD if t < 0.5 else None)
    asked, notes = followed(motion, 1.0)
    assert asked[0.495] == asked[0.51] == AHEAD  # a cycle or two without news is no silence
    assert all(twist == AT_REST for t, twist in asked.items() if t >= 0.515)  # 20 ms of silence
    assert [(round(t, 6), note.kind) for t, note in notes] == [(0.595, "silence")]
    assert "the hand brakes from 20 ms on" in notes[0][1].message


def test_who_is_only_late_is_followed_again_and_told_once():
    """Words 45 ms apart: the hand brakes in between, and no twist of zero is asked for."""
    asked, notes = followed(heard(lambda t: AHEAD if round(t / PERIOD) % 9 == 0 else None), 1.0)
    assert asked[0.045] == asked[0.06] == asked[0.09] == AHEAD
    assert asked[0.065] == asked[0.085] == AT_REST
    assert [note.kind for _, note in notes] == ["late"]
    assert "45 ms after the last: from 20 ms on (reference.silence)" in notes[0][1].message
    slow, notes = followed(
        heard(lambda t: AHEAD if round(t / PERIOD) % 9 == 0 else None, silence=0.06), 1.0
    )
    assert all(twist == AHEAD for t, twist in slow.items() if t >= 0.045)
    assert not notes


@pytest.mark.parametrize("seed", range(12))
def test_a_hand_that_falls_silent_is_at_rest_in_time(seed):
    """At a drawn moment of drawn twists, with drawn limits; by default within 100 ms."""
    rng = np.random.default_rng((72, seed))
    limits = {
        "rate_limits": tuple(rng.uniform(0.5, 6.0, 6)),
        "acceleration_limits": tuple(rng.uniform(5.0, 50.0, 6)),
    }
    geometry = ArmGeometry(**limits if seed % 3 else {})
    told = {"rest": rng.uniform(0.06, 0.3), "silence": rng.uniform(0.005, 0.045)}
    told = told if seed % 2 else {}
    moment, twist = rng.uniform(0.1, 2.0), rng.normal(size=6) * rng.uniform(0.1, 3.0)
    turned = rng.uniform(0.0, moment)
    motion = heard(
        lambda t: None if t > moment else tuple(twist if t < turned else -twist),
        duration=5.0,
        **told,
    )
    law = Esc(EscSettings(), geometry, PERIOD)
    law.prepare_twists(motion._twists)
    here, moving, fastest = motion._at_rest, 0.0, 0.0
    for k in range(1, round((moment + 0.6) / PERIOD)):
        t = k * PERIOD
        motion.see(t, None, here)
        command = law.update(None, motion.at(t))
        here = here._replace(positions=command.positions)
        moving = t if any(command.velocities) else moving
        shares = np.abs(command.velocities) / geometry.rate_limits
        fastest = max(fastest, shares.max())
    assert fastest > 0.2
    assert moment - PERIOD < moving
    assert moving + PERIOD - moment <= told.get("rest", 0.1) + 1e-9


def test_who_needs_the_whole_rate_allows_the_time_to_rest():
    assert slowed_to_rest(ArmGeometry(), 15, PERIOD).rate_limits == pytest.approx(
        (0.75, 0.75, 0.75, 1.5, 1.5, 1.5)
    )
    assert periods_to_rest(Told(), PERIOD) == 15
    assert heard(lambda t: AHEAD).remarks[0].message == (
        "joints keep to 0.75 of their rates, so that the hand is at rest 100 ms after the last "
        "word (reference.rest)"
    )
    assert not heard(lambda t: AHEAD, rest=0.13).remarks


def test_a_rest_that_leaves_no_time_to_brake_is_refused():
    with pytest.raises(InfeasibleMotion, match=r"A rest of 95 ms or more, or less silence"):
        periods_to_rest(Told(silence=0.085, rest=0.09), PERIOD)


def test_after_silence_the_hand_waits_for_a_twist_of_zero():
    def say(t):
        if 0.2 < t < 0.4:
            return None
        return AT_REST if 0.6 <= t < 0.61 else AHEAD

    asked, notes = followed(heard(say), 1.0)
    assert all(twist == AT_REST for t, twist in asked.items() if 0.3 < t < 0.61)
    assert asked[0.7] == AHEAD
    assert [note.kind for _, note in notes] == ["silence", "twist"]


def test_silence_cannot_be_set_beyond_a_tenth_of_a_second():
    from rig.mechanisms.arm.references import TwistRows as Named

    assert Named is TwistRows
    hint = ArmTwists.__annotations__["silence"]
    assert hint.__metadata__[1].le == 0.1


@pytest.mark.parametrize(
    "told",
    [(1.0, 2.0), (math.nan,) * 6, (math.inf, *(0.0,) * 5), "left", 3.0, (*(0.0,) * 5, -1e308)],
)
def test_nonsense_makes_the_rig_safe(told):
    motion = heard(lambda _: told)
    with pytest.raises(SafetyError, match=r"Told\.twist\(\)"):
        motion.see(PERIOD, None, HERE)


def test_twists_in_the_tools_axes_turn_with_it():
    motion = heard(lambda _: (0.0, 0.0, 0.1, 0.0, 0.0, 0.2), frame="tool")
    motion.see(PERIOD, None, HERE)
    lean = 0.3 + 1.5 + 0.5  # q1 = q4 = 0: the tool leans by q2 + q3 + q5 from the vertical
    x, z = math.sin(lean), math.cos(lean)
    assert motion.at(PERIOD).twist == pytest.approx((0.1 * x, 0, 0.1 * z, 0.2 * x, 0, 0.2 * z))


def test_before_the_start_and_beyond_the_end_the_arm_rests():
    motion = heard(lambda _: AHEAD, duration=0.1)
    assert not motion.at(0.0).following
    motion.see(0.05, None, HERE)
    assert motion.at(0.05).twist == AHEAD
    motion.see(0.1, None, HERE)
    assert motion.at(0.1).twist == AT_REST
    assert motion.duration > 0.1
    assert not motion.foreseen.at(0.05).following


# A gamepad ----------------------------------------------------------------------------------


class FakePad:
    """A gamepad whose events a test writes."""

    def __init__(self):
        self.fd, self._out = os.pipe()
        self.queue = []
        self.closed = self.broken = False

    def absinfo(self, code):
        return SimpleNamespace(min=-1, max=1) if code >= 0x10 else SimpleNamespace(min=0, max=255)

    def capabilities(self, absinfo=True):
        assert not absinfo
        return {1: [0x130, 0x136], 3: [0x00, 0x01, 0x03, 0x04, 0x10, 0x11]}

    def press(self, *events):
        self.queue += [SimpleNamespace(type=a, code=b, value=c) for a, b, c in events]
        os.write(self._out, b".")

    def read(self):
        os.read(self.fd, 1)
        if self.broken:
            raise OSError("No such device")
        events, self.queue = self.queue, []
        return events

    def close(self):
        self.closed = True


@pytest.fixture
def pad(monkeypatch):
    pad = FakePad()
    module = SimpleNamespace(InputDevice=lambda _: pad, list_devices=lambda: ["/dev/input/event0"])
    monkeypatch.setitem(sys.modules, "evdev", module)
    return pad


def newest(ear, until, seconds=5.0):
    """Return the first twist that a condition holds of."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        twist = ear.twist(0.0)
        if twist is not None and until(twist):
            return twist
        time.sleep(1e-3)
    pytest.fail("the gamepad was not heard")
    return None


def test_sticks_move_the_hand_while_the_button_is_held(pad):
    twists = GamepadTwists(speed=0.2, turn_rate=1.0, dead_zone=0.1)
    assert twists.known() is None
    ear = twists.listen()
    try:
        pad.press((3, 0x01, 0))  # pushed away, and the button not held
        assert newest(ear, lambda _: True) == AT_REST
        pad.press((1, 0x136, 1), (3, 0x10, 1))
        twist = newest(ear, any)
        assert twist == pytest.approx((0.2, 0, 0, 1.0, 0, 0))
        pad.press((1, 0x136, 0))
        assert newest(ear, lambda one: not any(one)) == AT_REST
    finally:
        ear.leave()
    assert pad.closed


def test_a_gamepad_that_is_pulled_out_falls_silent(pad):
    ear = GamepadTwists().listen()
    newest(ear, lambda _: True)
    pad.broken = True
    pad.press((1, 0x136, 1))
    ear._thread.join(timeout=5.0)
    assert ear.twist(0.0) == AT_REST  # at once, without waiting for the silence
    assert ear.twist(0.0) is None
    ear.leave()


@pytest.mark.parametrize("seed", range(4))
def test_a_drawn_stream_of_events_is_where_the_sticks_are(pad, seed):
    """Each stick beyond its dead zone in proportion, the button last pressed or let go."""
    rng = np.random.default_rng((71, seed))
    ends = {0x00: (0, 255), 0x01: (0, 255), 0x03: (0, 255), 0x04: (0, 255),
            0x10: (-1, 1), 0x11: (-1, 1)}  # fmt: skip
    entries = {
        0x01: (0, -1),
        0x00: (1, -1),
        0x04: (2, -1),
        0x03: (5, -1),
        0x10: (3, 1),
        0x11: (4, 1),
    }
    scale, dead = np.array([0.2] * 3 + [0.7] * 3), float(rng.uniform(0.0, 0.4))
    ear = GamepadTwists(speed=0.2, turn_rate=0.7, dead_zone=dead).listen()
    sticks, held = np.zeros(6), False
    try:
        for _ in range(12):
            events = []
            for _ in range(rng.integers(1, 9)):
                if rng.random() < 0.3:
                    held = bool(rng.random() < 0.7)
                    events.append((1, 0x136, int(held)))
                    continue
                code = int(rng.choice(list(ends)))
                low, high = ends[code]
                value = int(rng.integers(low, high + 1))
                place, sign = entries[code]
                way = 2.0 * (value - low) / (high - low) - 1.0
                sticks[place] = sign * math.copysign(max(abs(way) - dead, 0.0) / (1.0 - dead), way)
                events.append((3, code, value))
            if rng.random() < 0.2:  # the kernel lost some: the button counts as let go
                events.append((0, 3, 0))
                sticks, held = np.zeros(6), False
            wanted = scale * sticks if held else np.zeros(6)
            pad.press((1, 0x131, 1), *events)
            newest(ear, lambda twist, wanted=wanted: np.allclose(twist, wanted, atol=1e-12))
    finally:
        ear.leave()


def test_what_has_no_sticks_is_no_gamepad(pad, monkeypatch):
    monkeypatch.setattr(FakePad, "capabilities", lambda *_, **__: {1: [0x136], 3: []})
    with pytest.raises(InfeasibleMotion, match=r"/dev/input/event3 is no gamepad: it lacks"):
        GamepadTwists(device="/dev/input/event3").known()
    with pytest.raises(InfeasibleMotion, match="there is no gamepad among"):
        GamepadTwists().known()
    assert pad.closed


def test_a_simulation_keeps_to_the_time_of_whoever_holds_a_gamepad(pad):
    del pad
    assert HeardTwists(GamepadTwists(), ArmGeometry(), PERIOD).real_time
    assert not heard(None).real_time


def test_what_is_missing_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "evdev", None)
    with pytest.raises(InfeasibleMotion, match=r"pip install -e .*\[gamepad\]"):
        GamepadTwists().known()
    empty = SimpleNamespace(InputDevice=None, list_devices=list)
    monkeypatch.setitem(sys.modules, "evdev", empty)
    with pytest.raises(InfeasibleMotion, match="there is no gamepad"):
        GamepadTwists().known()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("speed", [0.0, 5e-324, 1e-300, 1e-160, 1e-30])
def test_a_twist_that_is_none_but_for_rounding_has_facts_that_are_numbers(speed):
    """Its square is nought: how far the hand has gone along it is not asked."""
    rows = ((0.0, speed, 0.0, 0.0, 0.0, 0.0, 0.0), (1.0, *AT_REST))
    law = Esc(EscSettings(), ArmGeometry(), PERIOD)
    law.longest = 10.0
    geometry = ArmGeometry()
    twists = TwistRows(rows=rows)
    facts = facts_of_twists(law.prepare_twists(twists), geometry, twists)
    assert facts["off_direction"].value < 1e-9
    assert not any(math.isnan(fact.value) for fact in facts.values())


def test_who_would_start_outside_a_range_is_refused():
    """Twists that are heard are not gone through beforehand: only their start is known."""
    law = Esc(EscSettings(), ArmGeometry(), PERIOD)
    twists = Told(start=(0.0, 0.3, 2.9, 0.0, 0.5, 0.0))
    with pytest.raises(InfeasibleMotion, match=r"^q3 would start at 2.9000 rad, .*-2.8000 to 2.80"):
        law.prepare_twists(twists)
