"""Regulators, encoders and a stop made by hand, and mechanisms on them; numbers are dyadic.

Sums and differences of multiples of 2**-45 are exact here, so that a test can stand on a bound and
`TINY` beside it.
"""

from rig.hal import (
    Device,
    EmergencyStopInput,
    LinearEncoder,
    MarkerCamera,
    Markers,
    PressureRegulator,
    Reading,
)
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.mechanisms.cylinder.settings import CylinderLimits, CylinderSettings, FrictionModel

TINY = 2.0**-45
PERIOD = 2.0**-10
AGE = 2.0**-6
HOME, STROKE = 2.0**-5, 2.0**-4
REACH, MISMATCH, SPEED = 2.0**-6, 2.0**-9, 0.5
LOWEST, HIGHEST, BASE = 10e3, 500e3, 120e3


class Idle(Device):
    """The life cycle of a device to which nothing happens."""

    def connect(self):
        pass

    def arm(self):
        pass

    def check(self, now):
        pass

    def make_safe(self):
        pass

    def close(self):
        pass


class FakeRegulators(Idle, PressureRegulator):
    """Chambers that read what a test says."""

    def __init__(self, channels, name="regulators", pressure_range=(0.0, 500e3)):
        self.name = name
        self.channels = tuple(channels)
        self.pressure_range = pressure_range
        self.reads = (BASE,) * len(self.channels)
        self.t = 0.0
        self.sent = []

    def pressure(self):
        return Reading(self.reads, self.t)

    def set_pressure(self, pressure):
        self.sent.append(tuple(pressure))

    def safe_pressure(self):
        return (LOWEST,) * len(self.channels)


class HoldingRegulators(FakeRegulators):
    """Some of them keep their pressure in the safe state."""

    held = ()

    def safe_pressure(self):
        return self.held


class FakeEncoder(Idle, LinearEncoder):
    """One rod that stands where a test says."""

    channels = ("position",)

    def __init__(self, name, stroke=STROKE):
        self.name = name
        self.stroke = stroke
        self.extension = HOME
        self.t = 0.0

    def position(self):
        return Reading((self.extension,), self.t)

    def velocity(self):
        return Reading((0.0,), self.t)


class FakeCamera(Idle, MarkerCamera):
    """Sees the marker where a test says, if anywhere."""

    def __init__(self, name="camera", sphere_radius=None):
        self.name = name
        self.t = 0.0
        self.sees = Markers((), ())
        self.radius = sphere_radius

    @property
    def sphere_radius(self):
        return self.radius

    def markers(self):
        return Reading(self.sees, self.t)


class FakeStop(EmergencyStopInput):
    """An emergency stop."""

    def __init__(self):
        self.name = "stop"
        self.pressed = False
        self.t = 0.0

    def emergency_stop(self):
        return Reading(self.pressed, self.t)


def pair_limits(**changes):
    limits = {
        "position": (-REACH, REACH),
        "speed": SPEED,
        "pressure": (LOWEST, HIGHEST),
        "pressure_rate": 1e9,
        "pair_force": 60.0,
        "reading_age": AGE,
        "mismatch": MISMATCH,
    }
    return CylinderLimits(**(limits | changes))


def pair_settings(limits=None, **changes):
    settings = {
        "regulators": "regulators",
        "encoder_agonist": "encoder-agonist",
        "encoder_antagonist": "encoder-antagonist",
        "bore": 16e-3,
        "rod": 5e-3,
        "stroke": STROKE,
        "home": HOME,
        "moving_mass": 0.14,
        "base_pressure": BASE,
        "friction": FrictionModel(10.0, 13.0, 8e-3, 50.0),
        "limits": limits or pair_limits(),
    }
    return CylinderSettings(**(settings | changes))


class PairBench:
    """A pair on devices of which each reads what a test says."""

    def __init__(self, settings=None, regulators=None):
        self.regulators = regulators or FakeRegulators(("agonist", "antagonist"))
        self.agonist = FakeEncoder("encoder-agonist")
        self.antagonist = FakeEncoder("encoder-antagonist")
        self.stop = FakeStop()
        self.pair = AntagonisticPair(
            settings or pair_settings(),
            regulators=self.regulators,
            encoder_agonist=self.agonist,
            encoder_antagonist=self.antagonist,
            emergency_stop=self.stop,
            period=PERIOD,
        )

    def place(self, agonist, antagonist):
        """Put the rods, as extensions beyond home, m."""
        self.agonist.extension, self.antagonist.extension = HOME + agonist, HOME + antagonist

    def move_to(self, position):
        """Put the pair, m."""
        self.place(-position, position)

    def refresh(self, now):
        for device in (self.regulators, self.agonist, self.antagonist, self.stop):
            device.t = now

    def cycle(self, now, fresh=True):
        """Read and check, all readings being of now if they are fresh."""
        if fresh:
            self.refresh(now)
        state = self.pair.read(now)
        self.pair.check(state, now)
        return state
