"""The cycle with fake parts: order, deadlines, and safety on every way out."""

import pytest
from loop_fakes import PERIOD, Bench, FakeBus, FakeDevice, FakeMechanism

from rig.hal import DeviceFault, LimitExceeded, LoopStalled, StaleReading
from rig.runtime.loop import SAFE_CYCLES, Loop
from rig.runtime.phases import Phase
from rig.runtime.states import RigState
from rig.runtime.stop import StopRequests


def test_a_run_goes_through_its_phases_and_starts_bumplessly():
    bench = Bench()
    outcome = bench.run()
    assert (outcome.fault, outcome.stopped, outcome.missed) == (None, 0, 0)
    assert bench.states.state is RigState.IDLE
    phases = [row[0] for _, _, row in bench.recorder.rows]
    assert phases == sorted(phases) and set(phases) == {0.0, 1.0, 2.0}
    assert bench.mechanism.written[0] == 7.0  # what was measured: nothing jumps
    assert bench.mechanism.written[-1] == 0.0
    assert bench.controller.resets == [7.0]
    assert any(event[1] == "limit" and "range" in event[2] for event in bench.events)


def test_a_limit_is_told_when_it_begins_to_clip():
    bench = Bench()
    counts = {5: 1, 6: 2, 7: 3, 20: 4}

    def clip():
        cycle = len(bench.recorder.rows)
        bench.mechanism.hits["rate"] = counts.get(cycle, bench.mechanism.hits["rate"])

    bench.recorder.busy = clip
    bench.run()
    told = [(t, message) for t, kind, message, _ in bench.events if kind == "limit"]
    starts = [round(t, 3) for t, message in told if message == "rate is limited"]
    assert starts == [0.05, 0.19]
    assert told[-1][1] == "rate was limited in 4 cycles of the run"


def test_each_cycle_drains_before_it_sends():
    bench = Bench()
    bench.run()
    cycle = bench.bus.calls[:3]
    assert cycle == ["receive", "check", "transmit"]


def test_late_cycle_skips_ticks_and_keeps_to_the_grid():
    bench = Bench()

    def busy():
        if len(bench.recorder.rows) == 3:
            bench.clock.time += 2.5 * PERIOD

    bench.recorder.busy = busy
    outcome = bench.run()
    ticks = [cycle for cycle, _, _ in bench.recorder.rows]
    assert outcome.missed == 2
    assert ticks[:5] == [0, 1, 2, 5, 6]  # never two at once to catch up
    for cycle, t, _ in bench.recorder.rows:
        assert t == pytest.approx(cycle * PERIOD)
    assert any(event[1] == "overrun" for event in bench.events)


def test_too_many_late_cycles_in_a_row_are_a_fault():
    bench = Bench(max_missed=5)
    bench.recorder.busy = lambda: setattr(bench.clock, "time", bench.clock.time + 3 * PERIOD)
    outcome = bench.run()
    assert isinstance(outcome.fault, LoopStalled)
    assert bench.states.state is RigState.FAULT


@pytest.mark.parametrize("error", [DeviceFault("drive", "its watchdog tripped"), None])
def test_what_a_device_does_right_after_a_pause_is_the_pauses_doing(error):
    bench = Bench(max_missed=5)
    error = error or StaleReading("drive", 0.05, 0.03)
    blamed = {}
    for when in (1, 5, 7):
        bench = Bench(max_missed=5)

        def busy(bench=bench, when=when):
            if len(bench.recorder.rows) == 3:
                bench.clock.time += 4.5 * PERIOD
            if len(bench.recorder.rows) == 3 + when:

                def check(now):
                    raise error

                bench.device.check = check

        bench.recorder.busy = busy
        blamed[when] = bench.run().fault
    for when in (1, 5):
        assert isinstance(blamed[when], LoopStalled)
        assert str(blamed[when]) == f"the program was paused for 35.0 ms, and then {error}"
    assert blamed[7] is error


def test_a_pause_is_no_excuse_for_a_value_that_is_not_safe():
    bench = Bench(max_missed=5)

    def check(state, now):
        if len(bench.recorder.rows) > 3:
            raise LIMIT

    def busy():
        if len(bench.recorder.rows) == 3:
            bench.clock.time += 4.5 * PERIOD

    bench.recorder.busy, bench.mechanism.check = busy, check
    assert bench.run().fault is LIMIT


def test_a_fault_at_the_wake_from_a_short_pause_comes_after_its_event():
    bench = Bench(max_missed=5)
    bench.clock.oversleep = (0.05, 3.5 * PERIOD)
    bench.device.fault_at = 0.05 + 0.5 * PERIOD
    fault = bench.run().fault
    assert str(fault) == "the program was paused for 35.0 ms, and then device: it broke"
    (overrun,) = [event for event in bench.events if event[1] == "overrun"]
    assert overrun[2] == "3 ticks missed"
    assert bench.recorder.rows[-1][1] == pytest.approx(0.05 + 3.5 * PERIOD)


@pytest.mark.parametrize("ticks", [5.9, 6.1, 40.0])
def test_who_wakes_up_far_too_late_sends_nothing_and_says_why(ticks):
    bench = Bench(max_missed=5)
    bench.clock.oversleep = (0.05, ticks * PERIOD)
    bench.device.fault_at = 0.05 + 0.5 * PERIOD  # what it does while nobody speaks to it
    fault = bench.run().fault
    assert isinstance(fault, LoopStalled)
    assert str(fault).startswith(f"the program was paused for {1e3 * ticks * PERIOD:.1f} ms")
    *_, (_, t, _) = bench.recorder.rows
    assert t == pytest.approx(0.05 + ticks * PERIOD)
    assert bench.mechanism.written[-1] == 0.0


def test_cycle_that_sees_a_fault_is_recorded_with_what_is_sent_then():
    bench = Bench()
    bench.device.fault_at = 0.12
    outcome = bench.run()
    assert isinstance(outcome.fault, DeviceFault)
    assert bench.recorder.rows[-1][1] == pytest.approx(0.12)
    assert bench.mechanism.written[-1] == 0.0
    assert bench.device.safe >= SAFE_CYCLES


def test_a_log_that_fails_does_not_hide_the_fault_that_was_seen_first():
    bench = Bench()
    bench.device.fault_at = 0.0
    bench.recorder.busy = lambda: (_ for _ in ()).throw(OSError("disk full"))
    assert isinstance(bench.run().fault, DeviceFault)
    assert bench.device.safe >= SAFE_CYCLES


@pytest.mark.parametrize("where", ["controller", "recorder", "transmit", "interrupt"])
def test_every_way_out_makes_safe_for_several_cycles(where):
    bench = Bench()
    if where == "controller":
        bench.controller.error = ZeroDivisionError("a bug")
    elif where == "recorder":
        bench.recorder.busy = lambda: (_ for _ in ()).throw(OSError("disk full"))
    elif where == "transmit":
        bench.bus.fail.add("transmit")
    else:
        bench.controller.error = KeyboardInterrupt()
    if where == "interrupt":
        with pytest.raises(KeyboardInterrupt):
            bench.run()
    else:
        assert bench.run().fault is not None
        assert bench.states.state is RigState.FAULT
    assert bench.device.safe >= SAFE_CYCLES


def test_dead_bus_does_not_keep_another_from_its_safe_state():
    bench = Bench()
    dead, alive = FakeBus("dead"), FakeBus("alive")
    bench.buses = [dead, alive]
    bench.device.fault_at = 0.0
    dead.fail |= {"receive", "transmit"}
    dead.fail.discard("receive")
    bench.run()
    assert dead.calls.count("make_safe") == SAFE_CYCLES
    assert alive.calls.count("transmit") >= SAFE_CYCLES


def test_stop_asked_twice_ends_at_once():
    bench = Bench()
    stop = StopRequests()
    bench.recorder.busy = lambda: stop.request() if len(bench.recorder.rows) in (12, 13) else None
    outcome = bench.run(stop)
    assert outcome.stopped == 2
    assert len(bench.recorder.rows) == 14
    assert bench.recorder.rows[-1][2][0] == float(Phase.STOP)
    assert bench.device.safe >= SAFE_CYCLES


@pytest.mark.parametrize("cycle", [7, 12, None])
def test_orderly_stop_is_controlled_until_the_rig_rests_and_then_released_from_balance(cycle):
    bench = Bench()
    stop = StopRequests()
    bench.mechanism.balanced_command = lambda state: 33.0
    bench.recorder.busy = lambda: stop.request() if len(bench.recorder.rows) == cycle else None
    bench.run(stop, brake=0.1, settle=0.05)
    phases = [row[0] for _, _, row in bench.recorder.rows]
    first = phases.index(float(Phase.STOP))
    held = bench.mechanism.written[first : first + 15]
    assert held[-5:] == pytest.approx([held[-1]] * 5)
    assert all(value > 7.0 for value in held)
    released = bench.mechanism.written.index(33.0) - first
    assert released in (15, 16)  # by rounding of times
    assert bench.mechanism.written[-1] == 0.0


def test_fault_of_the_controller_during_an_orderly_stop_is_a_fault():
    bench = Bench()

    def refuse():
        if bench.recorder.rows[-1][2][0] == float(Phase.STOP):
            bench.controller.error = ValueError("no way on")

    bench.recorder.busy = refuse
    outcome = bench.run(brake=0.1, settle=0.05)
    assert "the controller cannot go on: no way on" in str(outcome.fault)
    assert bench.device.safe >= SAFE_CYCLES


class VentingDevice(FakeDevice):
    """Is safe only after so many safe setpoints."""

    def __init__(self, name="regulators", after=30):
        super().__init__()
        self.name = name
        self.after = after

    def unsafe(self, now):
        return "" if self.safe >= self.after else f"{self.name}: ch3 still holds 45.7 kPa"


def test_safe_setpoints_are_repeated_until_the_devices_say_that_they_are_safe():
    bench = Bench()
    bench.devices = [bench.device, VentingDevice()]
    assert bench.run().unsafe == ()
    assert bench.device.safe == 30


def test_what_is_not_safe_in_time_is_told_and_nothing_waits_for_ever():
    bench = Bench(safe_within=0.2)
    bench.devices = [VentingDevice("first", 10**9), VentingDevice("second"), bench.device]
    outcome = bench.run()
    assert outcome.unsafe == (
        "first: ch3 still holds 45.7 kPa",
        "second: ch3 still holds 45.7 kPa",
    )
    assert bench.device.safe == round(0.2 / PERIOD)


@pytest.mark.parametrize(
    ("vents", "safe_within", "fails", "cycles"),
    [
        (0.3, 1.0, True, 30),
        (0.3, 0.1, True, 10),
        (0.0, 1.0, True, SAFE_CYCLES),
        (0.3, 1.0, False, 30),
    ],
)
def test_no_reading_is_believed_before_chambers_can_be_empty(vents, safe_within, fails, cycles):
    """A monitor frozen at nothing says at once that nothing is left, one that is off too soon."""
    bench = Bench(safe_within=safe_within)
    bench.mechanism.venting_time = vents
    if fails:
        bench.mechanism.check = lambda state, now: 1 / 0
    outcome = bench.run()
    assert (outcome.fault is not None) is fails
    assert bench.device.safe == cycles


@pytest.mark.parametrize("times", [1, 2])
def test_every_stop_waits_for_the_chambers(times):
    bench, stop = Bench(), StopRequests()
    bench.mechanism.venting_time = 0.3
    asked = range(12, 12 + times)
    bench.recorder.busy = lambda: stop.request() if len(bench.recorder.rows) in asked else None
    assert bench.run(stop).stopped == times
    assert bench.device.safe == 30


def test_a_rig_that_was_never_run_is_made_safe_in_a_few_cycles():
    bench = Bench()
    loop = Loop(
        clock=bench.clock, period=PERIOD, buses=bench.buses, devices=bench.devices,
        mechanism=bench.mechanism, controller=bench.controller, states=bench.states,
    )  # fmt: skip
    assert loop.make_safe() == ()
    assert bench.device.safe == SAFE_CYCLES


def test_reading_back_that_fails_is_told_and_no_safe_state():
    bench = Bench(safe_within=0.1)
    bench.device.unsafe = lambda now: 1 / 0
    (sentence,) = bench.run().unsafe
    assert sentence.startswith("device: not known to be safe: ZeroDivisionError")


@pytest.mark.parametrize("answer", [None, -2.5, False, ("text",)])
def test_what_is_no_sentence_is_no_safe_state_and_says_whose_it_is(answer):
    bench = Bench(safe_within=0.1)
    bench.device.unsafe = lambda now: answer
    assert bench.run().unsafe == (f"device: unsafe returned {answer!r}",)


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (lambda now: "a chamber hides 60 kPa", "a chamber hides 60 kPa"),
        (lambda now: 1 / 0, "the mechanism: not known to be safe: ZeroDivisionError"),
        (lambda now: None, "the mechanism: unsafe returned None"),
    ],
)
def test_what_the_mechanism_has_seen_counts_beside_what_the_devices_say(answer, told):
    bench = Bench(safe_within=0.2)
    bench.mechanism.unsafe = answer
    (sentence,) = bench.run().unsafe
    assert sentence.startswith(told)
    assert bench.device.safe == round(0.2 / PERIOD)


def test_the_mechanism_is_asked_in_each_cycle_of_the_safe_stop():
    bench, asked = Bench(), []
    bench.mechanism.unsafe = lambda now: asked.append(now) or ""
    assert bench.run().unsafe == ()
    assert len(asked) == bench.device.safe == SAFE_CYCLES
    assert asked == pytest.approx([asked[0] + k * PERIOD for k in range(SAFE_CYCLES)])


def test_device_or_bus_that_raises_in_make_safe_keeps_no_other_from_it():
    bench = Bench()

    class Broken(FakeDevice):
        def make_safe(self):
            raise RuntimeError("a bug of the driver")

    dead, alive = FakeBus("dead"), FakeBus("alive")
    dead.fail |= {"transmit", "make_safe"}
    bench.buses, bench.devices = [dead, alive], [Broken(), bench.device]
    outcome = bench.run()
    assert "device: it cannot be made safe: RuntimeError('a bug of the driver')" in outcome.unsafe
    assert bench.device.safe >= SAFE_CYCLES
    assert alive.calls.count("transmit") >= SAFE_CYCLES


class DoubtfulDevice(FakeDevice):
    """Looks wrong, or does not."""

    def __init__(self, doubt):
        super().__init__()
        self.looks = doubt

    def doubt(self, now):
        return self.looks


class ExplainingMechanism(FakeMechanism):
    """Knows of some errors why they came."""

    knows = None

    def explain(self, error, state):
        return self.knows or error


LIMIT = LimitExceeded("position", 2.0, -1.0, 1.0, "m")


def fault_of(error, *doubts, mechanism=None):
    """Return the fault of a run that ends with an error of its mechanism."""
    bench = Bench()
    bench.mechanism = mechanism or bench.mechanism

    def check(state, now):
        raise error

    bench.mechanism.check = check
    bench.devices = [FakeDevice(), *(DoubtfulDevice(doubt) for doubt in doubts)]
    return bench.run().fault


def test_a_limit_that_is_exceeded_names_the_devices_that_are_doubted():
    assert fault_of(LIMIT) is LIMIT
    assert fault_of(LIMIT, None, None) is LIMIT
    fault = fault_of(LIMIT, "valve is stuck", None, "drive lags")
    assert str(fault) == f"{LIMIT}; valve is stuck; drive lags"
    assert (fault.value, fault.lower, fault.upper) == (2.0, -1.0, 1.0)


def test_other_faults_are_not_blamed_on_a_device_that_is_doubted():
    stale = StaleReading("encoder", 1.0, 0.1)
    assert fault_of(stale, "valve is stuck") is stale


def test_what_the_mechanism_knows_comes_before_what_the_devices_doubt():
    mechanism = ExplainingMechanism()
    assert str(fault_of(LIMIT, "valve is stuck", mechanism=mechanism)).endswith("valve is stuck")
    mechanism.knows = LimitExceeded("wire", 3.0, -1.0, 1.0, "m")
    assert fault_of(LIMIT, "valve is stuck", mechanism=mechanism) is mechanism.knows


class BewilderedMechanism(FakeMechanism):
    """Fails where it looks for a cause."""

    def explain(self, error, state):
        raise IndexError("nothing was read before")


def test_a_search_for_the_cause_that_fails_does_not_take_its_place():
    limit = LimitExceeded("position", 2.0, -1.0, 1.0, "m")
    fault = fault_of(limit, "valve is stuck", mechanism=BewilderedMechanism())
    assert str(fault) == f"{limit}; valve is stuck"
    (note,) = fault.__notes__
    assert note.endswith("IndexError('nothing was read before')")


def test_a_count_of_a_bus_that_begins_to_rise_is_told_once():
    bench = Bench()
    risen = {4: 1, 5: 1, 6: 2, 7: 3, 20: 4}

    def count():
        cycle = len(bench.recorder.rows)
        bench.bus.counts["lost"] = risen.get(cycle, bench.bus.counts.get("lost", 0))

    bench.recorder.busy = count
    bench.run()
    told = [(round(t, 3), message) for t, kind, message, _ in bench.events if kind == "bus"]
    words = "can0: error frames say that the controller has lost frames"
    assert told == [(0.03, words), (0.19, words)]


@pytest.mark.parametrize("told", ["t", "phases"])
def test_nobody_tells_a_loop_how_far_it_is(told):
    with pytest.raises(TypeError, match=told):
        Loop(clock=None, period=PERIOD, buses=(), devices=(), mechanism=None, controller=None,
             states=None, **{told: 0.0})  # fmt: skip
