"""A run's way cycle by cycle, in times that floating point holds exactly."""

import pytest
from loop_fakes import FakeController, FakeMechanism

from rig.hal import LimitExceeded, Motion, SafetyError
from rig.runtime.phases import UNANSWERED, Phase, Phases, Timings
from rig.runtime.states import RigState, StateMachine

P = 2.0**-7
BALANCED = 1000.0
TIMINGS = Timings(energise=4 * P, approach=4 * P, release=4 * P, brake=4 * P, settle=2 * P)


class Ramp(Motion):
    """A reference that says which time it belongs to, in periods."""

    duration = 8 * P
    segments = ()

    def at(self, t):
        return 128.0 + t / P


class Mechanism(FakeMechanism):
    """Its state is the number of the cycle."""

    def __init__(self):
        super().__init__()
        self.started = []

    def start_limiting(self, state):
        self.started.append(state)

    def balanced_command(self, state):
        return BALANCED + state


class Run(Phases):
    """A run whose cycles are called one by one."""

    def __init__(self, timings=TIMINGS, waits=False, stands=False, **mechanism):
        self.mechanism = type("Made", (Mechanism,), mechanism)()
        self.controller = FakeController()
        self.states = StateMachine()
        self.states.move(RigState.IDLE)
        self.states.move(RigState.RUNNING)
        motion = Ramp()
        motion.waits, motion.stands = waits, stands
        super().__init__(self.mechanism, self.controller, self.states, motion, timings, period=P)

    def go(self, cycles, stop=None):
        """Return references and commands of so many cycles; a stop is asked for before one."""
        stops = [0 if stop is None or k < stop else 1 for k in range(cycles)]
        return [self.step(k * P, float(k), stops[k]) for k in range(cycles)]


def test_what_a_run_says_before_it_begins():
    run = Run()
    assert (run.phase, run.start, run.t, run.cycles, run.missed) == (Phase.APPROACH, 0.0, 0.0, 0, 0)
    assert run.reference_time == -8 * P
    assert run.duration == 8 * P
    assert run.finished is False
    assert Timings() == (1.0, 2.0, 0.5, 0.25, 0.25)


def test_a_run_keeps_what_its_code_was_last_asked_with():
    run = Run()
    assert (run.state, run.reference, run.command) == (None,) * 3
    assert run.answer is UNANSWERED  # a law may answer None
    wanted = [reference for reference, _ in run.go(12)]
    assert run.state == 11.0
    assert run.reference == wanted[-1]
    assert run.answer == run.controller.update(run.state, run.reference)


def test_a_run_cycle_by_cycle():
    run = Run()
    gone = run.go(26)
    # Energised from what was measured first, and held there.
    assert gone[:4] == [(0.0, 25.0 * k) for k in range(4)]
    # From where the rig is by then to where the motion begins.
    assert gone[4:8] == [(4.0 + 31.0 * k,) * 2 for k in range(4)]
    assert gone[8:16] == [(128.0 + k,) * 2 for k in range(8)]
    # At its end the motion has no path left on which it could come to rest.
    assert gone[16:22] == [(136.0, 136.0)] * 6
    assert gone[22:] == [(22.0 + k, 1022.0 * (1.0 - k / 4)) for k in range(4)]
    assert not run.finished
    assert run.step(26 * P, 26.0, 0) == (26.0, 0.0)
    assert run.finished
    assert run.mechanism.started == [0.0]
    assert run.controller.resets == [4.0]


def test_the_phases_and_the_reference_time_of_a_run():
    run, phases = Run(), []
    for k in range(17):
        run.step(k * P, float(k), 0)
        phases.append(run.phase)
        assert run.reference_time == (k - 8) * P
        assert run.states.state is (RigState.STOPPING if k == 16 else RigState.RUNNING)
    assert phases == [Phase.APPROACH] * 8 + [Phase.RUN] * 8 + [Phase.STOP]


def test_a_stop_in_the_motion_goes_on_along_its_path():
    gone = Run().go(23, stop=10)
    references = [reference for reference, _ in gone[10:16]]
    assert references[0] == 130.0
    assert references[4:] == [132.0, 132.0]  # half of the time for braking further
    assert references == sorted(references)
    assert gone[16] == (16.0, 1016.0)


def test_a_stop_in_the_approach_goes_on_along_its_path():
    gone = Run().go(12, stop=6)
    references = [reference for reference, _ in gone[6:12]]
    assert references[0] == 4.0 + 31.0 * 2
    assert references[4:] == [128.0, 128.0]


def test_a_rig_is_watched_not_to_leave_its_place_while_it_is_energised_and_no_longer():
    homes = []
    run = Run(check_still=lambda self, home: homes.append(home))
    run.go(10)
    assert homes == [run.mechanism.reference_of(0.0)] * 4


def test_a_rig_that_is_meant_to_stand_is_watched_until_it_stops():
    homes = []
    run = Run(check_still=lambda self, home: homes.append(home), stands=True)
    run.go(16, stop=12)
    energised, standing = [run.mechanism.reference_of(0.0)] * 4, [run.mechanism.reference_of(4.0)]
    assert homes == energised + 8 * standing


def test_a_stop_while_energising_lets_go_at_once():
    run = Run()
    gone = run.go(7, stop=2)
    assert gone[2:] == [(2.0 + k, 1002.0 * (1.0 - k / 4)) for k in range(5)]
    assert run.finished
    assert run.controller.resets == []


def test_a_mechanism_that_brakes_by_itself_is_let_go_at_once():
    run = Run(brakes_itself=True)
    assert run.go(11, stop=10)[10] == (10.0, 1010.0)


@pytest.mark.parametrize(("brake", "settle"), [(0, 0), (0, 3), (3, 0), (2, 2), (1, 2)])
def test_control_goes_on_for_the_time_of_braking_and_settling(brake, settle):
    run = Run(TIMINGS._replace(brake=brake * P, settle=settle * P))
    gone = run.go(20, stop=10)
    released = [k for k, (reference, _) in enumerate(gone) if k >= 10 and reference == float(k)]
    assert released[0] == 10 + brake + settle
    assert gone[released[0]][1] == BALANCED + released[0]


@pytest.mark.parametrize(
    ("release", "rests", "cycles"), [(4, 0, 4), (4, 4, 4), (4, 8, 8), (0, 8, 0), (0, 0, 0)]
)
def test_a_release_lasts_until_what_brakes_by_itself_rests(release, rests, cycles):
    run = Run(TIMINGS._replace(release=release * P), stopping_time=rests * P)
    run.go(2)
    for k in range(cycles):
        assert run.step((2 + k) * P, 2.0, 1) == (2.0, 1002.0 * (1.0 - k / cycles))
        assert not run.finished
    assert run.step((2 + cycles) * P, 2.0, 1) == (2.0, 0.0)
    assert run.finished


def test_a_release_is_cut_short_by_what_moves_off():
    """Asked in each cycle of it and in no other; the run's events tell."""
    asked = []
    run = Run(strays=lambda self, state: asked.append(state) or state == 18.0)
    run.go(19, stop=10)  # braking and settling take six cycles
    assert asked == [16.0, 17.0, 18.0]
    assert run.finished
    assert [(kind, "released at once" in said) for kind, said in run.notes] == [("stop", True)]
    quiet = Run()
    quiet.go(21, stop=10)
    assert quiet.finished
    assert quiet.notes == []


def test_two_requests_end_a_run_at_once():
    run = Run()
    run.go(10)
    run.step(10 * P, 10.0, 2)
    assert run.finished
    assert run.phase is Phase.STOP


@pytest.mark.parametrize("waits", [True, False])
def test_only_a_motion_that_waits_is_held_by_ticks_that_were_missed(waits):
    run = Run(waits=waits)
    run.go(10)
    run.missed = 3
    run.step(13 * P, 13.0, 0)
    assert run.reference_time == (2 if waits else 5) * P


def test_what_a_controller_asks_for_is_checked_before_it_is_used():
    error = LimitExceeded("command", 2.0, -1.0, 1.0, "Pa")
    asked = []

    def check(self, reference, command):
        asked.append((reference, command))
        raise error

    run = Run(check_command=check)
    run.go(4)
    with pytest.raises(LimitExceeded) as caught:
        run.step(4 * P, 4.0, 0)
    assert caught.value is error
    assert asked == [(4.0, 4.0)]


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ValueError("no way on"), "no way on"),
        (OSError(28, "No space left on device"), "[Errno 28] No space left on device"),
        (BrokenPipeError(), "BrokenPipeError"),
        (ValueError("\ud800"), "\\ud800"),
    ],
    ids=["none", "its own disk", "its own pipe", "no text"],
)
def test_a_controller_that_cannot_go_on_is_a_fault_of_the_motion(error, said):
    run = Run()
    run.controller.error = error
    run.go(4)
    with pytest.raises(SafetyError) as caught:
        run.step(4 * P, 4.0, 0)
    assert str(caught.value) == f"the controller cannot go on: {said}"


class Watching(Ramp):
    """A motion that ends two periods after its third."""

    watches = True

    def __init__(self):
        self.seen = []

    def see(self, t, state, here):
        self.seen.append((t / P, state, here))
        if t < 3 * P:
            return ()
        self.duration = 5 * P
        return (("mark", "seen"),)


def test_a_motion_that_watches_sees_each_cycle_of_its_own_and_may_end_earlier():
    run, motion, told = Run(), Watching(), []
    run._motion, run._watches = motion, True
    run.go(20)
    assert motion.seen == [(float(k), 8.0 + k, 8.0 + k) for k in range(6)]
    assert run.phase is Phase.STOP
    run.t = 2.5
    run.hand_over(lambda *event: told.append(event))
    assert told == [(2.5, "mark", "seen", {})] * 3
    assert run.notes == []


def test_a_motion_that_watches_sees_nothing_once_a_stop_was_asked_for():
    run, motion = Run(), Watching()
    run._motion, run._watches = motion, True
    run.go(14, stop=10)
    assert [t for t, _, _ in motion.seen] == [0.0, 1.0]


def test_what_slips_while_it_is_energised_is_held_where_it_is_and_not_pulled_back():
    run = Run(has_slipped=lambda self, state: state == 2.0)
    gone = run.go(6)
    assert gone[:2] == [(0.0, 0.0), (0.0, 25.0)]
    # From there on the way begins where it slipped to, with what energises there.
    assert gone[2:4] == [(2.0, 100.0), (2.0, 100.0)]
    assert run.mechanism.started == [0.0, 2.0]
    assert gone[4:] == [(4.0 + 31.0 * k,) * 2 for k in range(2)]


def test_nothing_is_asked_whether_it_slipped_once_it_is_controlled():
    asked = []
    Run(has_slipped=lambda self, state: asked.append(state)).go(20, stop=12)
    assert asked == [0.0, 1.0, 2.0, 3.0]
