"""A loop whose clock, bus, device, mechanism, controller and log are made by hand."""

from rig.hal import Device, DeviceFault, Margin, Mechanism, Motion
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

PERIOD = 0.01


class FakeClock:
    """Virtual time; work takes what a test says."""

    def __init__(self):
        self.time = 0.0
        self.slept_to = []
        self.oversleep = (float("inf"), 0.0)

    def now(self):
        return self.time

    def sleep_until(self, t):
        self.slept_to.append(t)
        self.time = max(self.time, t)
        when, by = self.oversleep
        if self.time >= when - 1e-9:
            self.time += by
            self.oversleep = (float("inf"), 0.0)


class FakeBus:
    """Notes what the loop does to it."""

    def __init__(self, name="can0"):
        self.name = name
        self.calls = []
        self.fail = set()
        self.counts = {}

    def statistics(self):
        return dict(self.counts)

    def __getattr__(self, call):
        if call.startswith("_"):
            raise AttributeError(call)

        def note(*_):
            self.calls.append(call)
            if call in self.fail:
                raise OSError(f"{self.name} is down")

        return note


class FakeDevice(Device):
    """Faults when told to; counts how often it was made safe."""

    def __init__(self):
        self.name = "device"
        self.safe = 0
        self.fault_at = float("inf")

    def connect(self):
        raise AssertionError("a loop is given devices that are armed")

    arm = close = connect

    def check(self, now):
        if now >= self.fault_at:
            raise DeviceFault(self.name, "it broke")

    def make_safe(self):
        self.safe += 1


class FakeMechanism(Mechanism):
    """One scalar that is commanded and read back."""

    columns = ()

    def __init__(self):
        self.written = []
        self.value = 7.0
        self.hits = {"range": 2, "rate": 0}

    @classmethod
    def assemble(cls, *_):
        raise AssertionError("a loop is given a mechanism and a motion")

    model_of = plan = assemble

    def read(self, now):
        return self.value

    def check(self, state, now):
        pass

    def resting_command(self, state):
        return state

    def energised_command(self, state):
        return 100.0

    def released_command(self):
        return 0.0

    def blend(self, start, end, share):
        return start + share * (end - start)

    def start_limiting(self, state):
        pass

    @classmethod
    def approach(cls, start, end, duration, t):
        return start + (end - start) * t / duration

    def limit(self, command):
        return command

    def write(self, applied):
        self.written.append(applied)

    def row(self, *values):
        return tuple(map(float, values))

    def reference_of(self, state):
        return state

    def worst_margin(self, *_):
        return Margin("nothing", 1.0)

    def limit_hits(self):
        return dict(self.hits)


class FakeController:
    """Commands its reference; may raise."""

    def __init__(self):
        self.resets = []
        self.error = None

    def reset(self, state):
        self.resets.append(state)

    def update(self, state, reference):
        if self.error:
            raise self.error
        return reference


class FakeMotion(Motion):
    duration = 0.1
    segments = ()

    def at(self, t):
        return 50.0


class FakeRecorder:
    def __init__(self):
        self.rows = []
        self.busy = lambda: None

    def write(self, cycle, t, row):
        self.rows.append((cycle, t, row))
        self.busy()


class Bench:
    def __init__(self, **loop):
        self.clock, self.bus, self.device = FakeClock(), FakeBus(), FakeDevice()
        self.mechanism, self.controller = FakeMechanism(), FakeController()
        self.recorder, self.states, self.events = FakeRecorder(), StateMachine(), []
        self.states.move(RigState.IDLE)
        self.buses, self.devices = [self.bus], [self.device]
        self.progress_every = 2 * PERIOD
        self.options = loop

    def run(self, stop=None, brake=0.0, settle=0.0, release=0.05, progress=None):
        loop = Loop(
            clock=self.clock, period=PERIOD, buses=self.buses, devices=self.devices,
            mechanism=self.mechanism, controller=self.controller, states=self.states,
            **self.options,
        )  # fmt: skip
        return loop.run(
            FakeMotion(),
            recorder=self.recorder,
            events=lambda *event: self.events.append(event),
            stop=stop or StopRequests(),
            timings=Timings(0.05, 0.05, release=release, brake=brake, settle=settle),
            progress=progress,
            progress_every=self.progress_every,
        )
