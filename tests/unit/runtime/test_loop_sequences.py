"""Any sequence of what operators and devices do: only a rig that runs is sent anything but safe.

The sequences go over several processes: a fault is kept in a file, as on hardware.
"""

import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from loop_fakes import PERIOD, Bench, FakeBus, FakeClock, FakeMechanism

from rig.cli.reset import _wait_for_edge
from rig.experiment.ending import fault_of
from rig.experiment.fault_latch import FaultLatch, FaultLatched
from rig.hal import DeviceFault, EmergencyStop, EmergencyStopInput, Reading
from rig.mechanisms.stop_contact import StopContact
from rig.runtime.states import IllegalMove, RigState, StateMachine
from rig.runtime.stop import StopRequests

SAFE = 0.0
WAIT = 1.0
"""For how long an operator is waited for, s."""
CYCLE = st.integers(0, 26)
"""A run of the bench has 26 or 27 cycles, of which an orderly stop leaves some out."""
HAPPENINGS = ("fault", "stop", "press", "release", "bug", "refuse", "silent", "sleep")

HARMFUL = ("fault", "press", "silent", "sleep")
"""After these not even one setpoint more may leave."""


class Contact(EmergencyStopInput):
    """A contact that latches what a look has seen, as the drivers do."""

    def __init__(self):
        self.name = "contact"
        self.pressed = self.seen = False
        self.t = 0.0

    def emergency_stop(self):
        self.seen = self.seen or self.pressed
        return Reading(self.pressed, self.t)

    def was_pressed(self):
        return self.seen


class WatchedMechanism(FakeMechanism):
    """Watches a contact; what it writes goes to the outputs of the one device."""

    def __init__(self, contact, outputs):
        super().__init__()
        self._contact = StopContact(contact, PERIOD)
        self._outputs = outputs

    def check(self, state, now):
        self._contact.device.t = now
        self._contact.check(now)

    def write(self, applied):
        super().write(applied)
        self._outputs.setpoint = applied


class Outputs(FakeBus):
    """The one bus: what it carries when it transmits is what leaves the program."""

    def __init__(self):
        super().__init__()
        self.setpoint = SAFE
        self.left = []
        self.state = lambda: RigState.DISCONNECTED
        self.refuses = False

    def transmit(self, now):
        if self.refuses:
            self.refuses = False
            raise OSError("the queue is full")
        self.left.append((self.state(), self.setpoint))


class Beside:
    """A rig whose contact an operator moves, look by look; then it cannot be read."""

    def __init__(self, looks):
        self.clock = FakeClock()
        self._looks = iter(looks)

    @contextmanager
    def watching_stop(self):
        yield lambda: next(self._looks, None)


class Rig(RuleBasedStateMachine):
    """One rig, its operators and its latch."""

    def __init__(self):
        super().__init__()
        self._folder = tempfile.TemporaryDirectory()
        self._before = os.environ.get("XDG_STATE_HOME")
        os.environ["XDG_STATE_HOME"] = self._folder.name
        self.latch = FaultLatch("rig")
        self.contact, self.outputs = Contact(), Outputs()
        self.faulted = False
        self.begin()

    def teardown(self):
        os.environ.pop("XDG_STATE_HOME")
        if self._before is not None:
            os.environ["XDG_STATE_HOME"] = self._before
        self._folder.cleanup()

    @precondition(lambda self: self.states.state is RigState.FAULT)
    @rule()
    def start_again(self):
        self.begin()

    def begin(self):
        self.states = StateMachine()
        self.outputs.state = lambda: self.states.state
        self.contact.seen = False

    @precondition(lambda self: self.states.state is RigState.DISCONNECTED)
    @rule()
    def connect(self):
        self.states.move(RigState.IDLE)
        self.contact.emergency_stop()

    @rule(pressed=st.booleans())
    def press_or_release(self, pressed):
        self.contact.pressed = pressed

    @rule(looks=st.lists(st.sampled_from((True, False, None)), max_size=5))
    def reset(self, looks):
        """Ask for a reset while the contact does this: only a press that is let go of is one."""
        edge = True in looks and False in looks[looks.index(True) :]
        assert (_wait_for_edge(Beside(looks), WAIT, None) is None) is edge
        if edge:  # as `rig reset` does
            FaultLatch("rig").clear()
            self.faulted = False

    @precondition(lambda self: self.states.state is RigState.IDLE and not self.faulted)
    @rule()
    def die_while_energised(self):
        """Nobody is left to say why; the next process finds the latch."""
        self.latch.set(Path("run"))
        self.faulted = True
        self.begin()

    @precondition(lambda self: self.states.state is not RigState.IDLE)
    @rule()
    def run_too_early(self):
        with pytest.raises(IllegalMove):
            self.run({})

    @precondition(lambda self: self.states.state is RigState.IDLE)
    @rule(happens=st.dictionaries(CYCLE, st.sampled_from(HAPPENINGS), max_size=3))
    def run_cycles(self, happens):
        try:
            self.latch.check()
        except FaultLatched:
            assert self.faulted
            return
        assert not self.faulted
        refused = self.contact.pressed or self.contact.seen
        self.latch.set(Path("run"))  # as `rig run` does before it energises
        sent = len(self.outputs.left)
        outcome = self.run(happens)
        if refused:
            assert isinstance(outcome.fault, EmergencyStop)
            assert {setpoint for _, setpoint in self.outputs.left[sent:]} == {SAFE}
        if outcome.fault is None:
            assert self.states.state is RigState.IDLE
            self.latch.clear()
        else:
            assert self.states.state is RigState.FAULT
            self.latch.settle(Path("run"), fault_of(outcome.fault, 0.0))
            self.faulted = True
        assert self.outputs.left[-1][1] == SAFE

    def run(self, happens):
        """Run a loop to which something happens after some of its cycles."""
        bench = Bench(max_missed=5)
        stop = StopRequests()
        bench.states = self.states
        bench.buses, outputs = [self.outputs], self.outputs
        bench.mechanism = WatchedMechanism(self.contact, outputs)
        plain_safe, bench.device.name = bench.device.make_safe, "valves"

        def make_safe():
            plain_safe()
            outputs.setpoint = SAFE

        def check(now):
            if broken:
                raise DeviceFault("valves", "it broke")

        def happen():
            what = happens.get(len(bench.recorder.rows) - 1)
            if what in HARMFUL:
                harmed.append(len(outputs.left))
            if what == "fault":
                broken.append(True)
            elif what == "stop":
                stop.request()
            elif what in ("press", "release"):
                self.contact.pressed = what == "press"
            elif what == "bug":
                bench.controller.error = ZeroDivisionError("a bug")
            elif what == "refuse":
                outputs.refuses = True
            elif what == "silent":
                raise OSError("disk full")
            elif what == "sleep":
                bench.clock.oversleep = (bench.clock.time, 20 * PERIOD)

        broken, harmed = [], []
        bench.device.make_safe, bench.device.check = make_safe, check
        bench.recorder.busy = happen
        outcome = bench.run(stop)
        for harm in harmed[:1]:
            assert {setpoint for _, setpoint in outputs.left[harm:]} == {SAFE}
        return outcome

    @invariant()
    def nothing_but_the_safe_setpoint_leaves_unless_running(self):
        for state, setpoint in self.outputs.left:
            assert setpoint == SAFE or state in (RigState.RUNNING, RigState.STOPPING)
        self.outputs.left.clear()
        assert self.outputs.setpoint == SAFE

    @invariant()
    def a_fault_stays_until_somebody_resets_it(self):
        assert (self.latch.reason() is not None) is self.faulted


TestSequences = Rig.TestCase
TestSequences.settings = settings(max_examples=150, stateful_step_count=20, deadline=None)


@pytest.mark.slow
def test_ten_thousand_sequences():
    many = settings(max_examples=10_000, stateful_step_count=20, deadline=None)
    run_state_machine_as_test(Rig, settings=many)
