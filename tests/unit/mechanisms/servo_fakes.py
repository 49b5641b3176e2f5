"""Servo drives made by hand, and three axes on two of them; every number is dyadic."""

from typing import NamedTuple

from pneumatic_fakes import FakeStop, Idle

from rig.hal import Reading, ServoBus
from rig.mechanisms.servo.axes import AxisLimits, Kinds, ServoAxes
from rig.mechanisms.servo.settings import ServoLimits

TINY = 2.0**-40
PERIOD = 2.0**-6
AGE = 2.0**-5
FOLLOWING = 2.0**-3
ACCELERATION = 8.0
STEP = ACCELERATION * PERIOD
"""By so much a speed may change in a period while axes brake, rad/s."""
NAMES = ("a", "b", "c")
LOWER, UPPER, RATES = (-1.0, -2.0, -0.5), (1.0, 0.5, 3.0), (1.0, 2.0, 0.5)


class State(NamedTuple):
    t: float
    positions: tuple
    velocities: tuple


class Reference(NamedTuple):
    positions: tuple
    velocities: tuple
    follow: bool


class Command(NamedTuple):
    positions: tuple
    velocities: tuple


class FakeServo(Idle, ServoBus):
    """Drives that stand where a test says."""

    is_enabled = False
    oldest_axis = ""

    def __init__(self, name, axis_names):
        self.name = name
        self.axis_names = tuple(axis_names)
        self.angles = (0.0,) * len(self.axis_names)
        self.speeds = (0.0,) * len(self.axis_names)
        self.t = 0.0
        self.sent = []

    def positions(self):
        return Reading(self.angles, self.t)

    def velocities(self):
        return Reading(self.speeds, self.t)

    def command_positions(self, positions):
        self.sent.append(positions)

    def command_velocities(self, velocities):
        raise AssertionError("a mechanism commands positions")

    def set_torque_enabled(self, enabled):
        raise AssertionError("a mechanism does not switch torque")


class BareAxes(ServoAxes):
    """Axes without what a mechanism adds to them."""

    @classmethod
    def assemble(cls, *_):
        raise AssertionError("these tests ask the axes alone")

    model_of = plan = approach = row = assemble


class ServoBench:
    """Axes a and c on one device, c first, and b on the other."""

    def __init__(self, **limits):
        self.left = FakeServo("left", ("c", "a"))
        self.right = FakeServo("right", ("b",))
        self.stop = FakeStop()
        values = {"following": FOLLOWING, "reading_age": AGE, "acceleration": ACCELERATION}
        self.axes = BareAxes(
            AxisLimits(NAMES, LOWER, UPPER, RATES),
            ServoLimits(**(values | limits)),
            [self.left, self.right],
            self.stop,
            Kinds(State, Reference, Command),
            PERIOD,
        )

    def place(self, a=0.0, b=0.0, c=0.0):
        self.left.angles, self.right.angles = (c, a), (b,)

    def turn(self, a=0.0, b=0.0, c=0.0):
        self.left.speeds, self.right.speeds = (c, a), (b,)

    def cycle(self, now=0.0):
        """Read and check, all readings being of now."""
        self.left.t = self.right.t = self.stop.t = now
        state = self.axes.read(now)
        self.axes.check(state, now)
        return state

    def start(self, a=0.0, b=0.0, c=0.0):
        """Take the axes where they are for those that were sent."""
        self.place(a, b, c)
        state = self.axes.read(0.0)
        self.axes.start_limiting(state)
        return state

    def limit(self, a=0.0, b=0.0, c=0.0):
        """Return what is applied of a command, as positions and speeds."""
        return self.axes.limit(Command((a, b, c), (9.0,) * 3))

    def move(self, a=0.0, b=0.0, c=0.0, cycles=1):
        """Command speeds for some cycles, rad/s, and return where the axes were sent."""
        for _ in range(cycles):
            before = self.axes._applied
            steps = [p + v * PERIOD for p, v in zip(before, (a, b, c), strict=True)]
            self.limit(*steps)
        return self.axes._applied
