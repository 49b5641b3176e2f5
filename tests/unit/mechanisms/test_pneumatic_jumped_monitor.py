"""A monitor that jumps within a cycle and stays, and the pressures that may look like it."""

import numpy as np
import pytest

from rig.mechanisms.pneumatic.alarms.jumped import Jump, JumpedMonitors

STEP, LEAST, JUMP = 2.0**-10, 2.0**14, 2.0**16
CALM = 10


class Shown:
    """Two monitors of pressures that are where they should be, but for what a test adds to one."""

    def __init__(self):
        self.jumped = JumpedMonitors(LEAST)
        self.cycle = 0
        self.pass_by([0.0] * CALM)

    def pass_by(self, offs, step=STEP, is_read=True):
        """Return what is found in each cycle; the pressures change a little unless none is read."""
        found = []
        for off in offs:
            self.cycle += is_read
            shown = (300e3 + self.cycle % 7, 200e3 + off)
            found.append(self.jumped.find((0.0, off), shown, step))
        return found


@pytest.mark.parametrize("jump", [JUMP, -JUMP, 1.01 * LEAST, -1.01 * LEAST])
def test_a_jump_that_stays_is_found_two_cycles_later_and_once(jump):
    assert Shown().pass_by([jump] * 6) == [None, None, Jump(1, jump, True), None, None, None]


def test_it_is_found_while_a_valve_makes_up_for_it():
    found = Shown().pass_by([JUMP, 0.9 * JUMP, 0.8 * JUMP, 0.7 * JUMP])
    assert found == [None, None, Jump(1, JUMP, True), None]


@pytest.mark.parametrize(
    "offs",
    [
        [LEAST] * 6,
        [-LEAST] * 6,
        [JUMP, 0.0, 0.0, 0.0],  # a spike
        [JUMP, JUMP, 0.0, 0.0],
        [JUMP, 0.7 * JUMP, 0.7 * JUMP, 0.7 * JUMP],
        [JUMP, JUMP, 0.7 * JUMP, 0.7 * JUMP],
        [-0.24 * JUMP, 0.66 * JUMP, 0.66 * JUMP, 0.66 * JUMP],
        [-0.3 * JUMP, 0.7 * JUMP, 0.7 * JUMP, 0.7 * JUMP],  # it has gone the other way before
        [0.3 * JUMP, 1.3 * JUMP, 1.3 * JUMP, 1.3 * JUMP],  # air begins to move, …
        [JUMP, 1.3 * JUMP, 1.5 * JUMP, 1.6 * JUMP],  # … and goes on to
        [k * LEAST for k in range(1, 9)],
    ],
)
def test_what_does_not_jump_and_stay_is_none(offs):
    assert set(Shown().pass_by(offs)) == {None}


def test_cycles_beside_a_jump_may_go_by_a_quarter_of_it():
    quarter = 0.25 * JUMP
    for before in (quarter, -quarter):
        found = Shown().pass_by([before, before + JUMP, before + JUMP + quarter, before + JUMP])
        assert found == [None, None, None, Jump(1, JUMP, True)]


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("share", [0.9, 1.0])
def test_a_jump_back_to_health_or_through_it_is_not_away(way, share):
    shown = Shown()
    shown.pass_by(np.linspace(0.0, way * JUMP, 100).tolist())
    shown.pass_by([way * JUMP] * CALM)
    found = [one for one in shown.pass_by([-share * way * JUMP] * 6) if one]
    assert found == [Jump(1, pytest.approx(-(1.0 + share) * way * JUMP), False)]


def test_a_small_jump_does_not_hide_the_large_one_after_it():
    small = 1.5 * LEAST
    found = Shown().pass_by([small, small + 5.0 * LEAST] + [small + 5.0 * LEAST] * 3)
    assert found == [None] * 5, "it goes on to"
    late = Shown().pass_by([small, small] + [small + 7.0 * LEAST] * 4)
    assert late == [None, None, None, None, Jump(1, 7.0 * LEAST, True), None]


def test_what_was_missed_while_frames_were_lost_is_none():
    shown = Shown()
    shown.pass_by([0.0] * 5, is_read=False)
    assert set(shown.pass_by([JUMP] * 6)) == {None}


@pytest.mark.parametrize("longer", [1.75, 20.0])
def test_what_was_missed_while_the_program_paused_is_none(longer):
    shown = Shown()
    for jump in (JUMP, 2.0 * JUMP):  # of two pauses the second is one, too
        assert shown.pass_by([jump], step=longer * STEP) == [None]
        assert set(shown.pass_by([jump] * 6)) == {None}


def test_nor_is_what_comes_right_after_a_pause():
    shown = Shown()
    shown.pass_by([0.0], step=20.0 * STEP)
    assert set(shown.pass_by([JUMP] * 6)) == {None}


def test_a_cycle_may_be_half_as_long_again():
    assert Shown().pass_by([JUMP], step=1.5 * STEP) == [None]
    shown = Shown()
    shown.pass_by([JUMP], step=1.5 * STEP)
    assert shown.pass_by([JUMP] * 2) == [None, Jump(1, JUMP, True)]


def test_the_other_monitor_is_told_from_it():
    jumped = JumpedMonitors(LEAST)
    found = [
        jumped.find((-JUMP * (k > 4), JUMP * (k > 90)), (1e5 + k, 1e5 - k), STEP) for k in range(9)
    ]
    assert found[:7] == [None] * 7
    assert found[7] == Jump(0, -JUMP, True)


def test_a_monitor_that_is_off_may_jump_once_more():
    shown = Shown()
    assert shown.pass_by([JUMP] * 20)[2] == Jump(1, JUMP, True)
    assert shown.pass_by([2.0 * JUMP] * 3)[-1] == Jump(1, JUMP, True)


class Vented:
    """A chamber that is vented behind a monitor, beside one that has been empty for long."""

    def __init__(self, fall=0.97):
        self.jumped = JumpedMonitors(LEAST)
        self.pressure, self.fall = 2.0**18, fall
        for _ in range(CALM):
            self.pressure += 1.0
            self.jumped.find((0.0, 0.0), (self.pressure, 0.0), STEP)
        self.jumped.follow_stop()

    def pass_by(self, jumps, step=STEP, is_read=True):
        """Return what is found while the monitor says so much more than there is."""
        found = []
        for jump in jumps:
            self.jumped.follow_stop()
            if is_read:
                self.pressure *= self.fall
                self.shown = (self.pressure + jump, 0.0)
            found.append(self.jumped.find(self.shown, self.shown, step))
        return found


def test_what_jumps_down_in_a_stop_is_found_beside_what_is_vented_or_not():
    for fall in (1.0 - 1e-6, 0.99, 0.97):
        vented = Vented(fall)
        assert set(vented.pass_by([0.0] * 40)) == {None}
        found = vented.pass_by([-JUMP] * 5)
        assert found[2][0] == 0
        assert found[2][1] == pytest.approx(-JUMP, rel=0.1)
        assert [*found[:2], *found[3:]] == [None] * 4


def test_in_a_stop_it_is_found_in_the_first_cycle_and_beside_frames_that_were_lost():
    assert Vented(1.0 - 1e-6).pass_by([-JUMP] * 3)[2] is not None
    vented = Vented(1.0 - 1e-6)
    vented.pass_by([0.0])
    assert vented.pass_by([-JUMP] * 2, is_read=False) == [None, None]
    assert vented.pass_by([-JUMP] * 3)[2] is not None


@pytest.mark.parametrize("unread", [3, 10])
def test_what_is_read_seldom_in_a_stop_falls_by_leaps(unread):
    vented, found = Vented(1.0 - 1e-6), []
    for _ in range(20):
        found += vented.pass_by([0.0]) + vented.pass_by([0.0] * unread, is_read=False)
    vented.pressure -= JUMP
    assert set(found + vented.pass_by([0.0] * 6)) == {None}


@pytest.mark.parametrize("fall", [0.9, 0.7, 0.5])
def test_a_chamber_that_empties_at_once_does_not_jump(fall):
    assert set(Vented(fall).pass_by([0.0] * 60)) == {None}


def test_what_jumps_back_in_a_stop_is_found():
    vented = Vented(0.99)
    vented.pass_by([-JUMP] * 9)
    found = [one for one in vented.pass_by([0.0] * 9) if one]
    assert [one[:2] for one in found] == [(0, pytest.approx(JUMP, rel=0.1))]
