"""A spherical joint on devices made by hand, and the rods of a pose."""

from pneumatic_fakes import (
    AGE,
    BASE,
    HIGHEST,
    HOME,
    LOWEST,
    PERIOD,
    SPEED,
    STROKE,
    FakeEncoder,
    FakeRegulators,
    FakeStop,
)

from controllers.spherical_joint.forward import ForwardKinematics
from controllers.spherical_joint.geometry import SphericalJointGeometry
from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.wires import InverseKinematics
from rig.mechanisms.joint.alarms.settings import JointAlarmSettings
from rig.mechanisms.joint.alarms.wires import WireLimits, WireWatch
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.settings import JointFriction, JointLimits, JointSettings
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm, PressureAlarm

GEOMETRY = SphericalJointGeometry()
CHANNELS = ("ch1", "ch2", "ch3", "ch4")
ENCODERS = ("e1", "e2", "e3", "e4")
TILT, EXCESS = 0.5, 0.125
RESIDUAL, GRACE = 2.0**-11, 2.0**-5
UPRIGHT = (0.0,) * 4
STIFF = 1e15
"""Of a wire, N/m: it does not stretch."""

_INVERSE = InverseKinematics(GEOMETRY, "exact", "natural")


def rods_at(tilt, azimuth):
    """Return by how much the wires are shorter in a pose than upright, m."""
    return _INVERSE.shortening(axis_from_tilt(tilt, azimuth))


def off(rods, number, error):
    """Return rods of which one (1 … 4) is off, m."""
    return tuple([rod + error if k == number - 1 else rod for k, rod in enumerate(rods)])


def residual_of(rods):
    """Return how far rods are from agreeing on a pose, m."""
    return ForwardKinematics(GEOMETRY).update(rods).residual


def joint_limits(**changes):
    limits = {
        "tilt": TILT,
        "tilt_excess": EXCESS,
        "speed": SPEED,
        "pressure": (LOWEST, HIGHEST),
        "pressure_rate": 1e9,
        "tension": (5.0, 90.0),
        "reading_age": AGE,
        "residual": RESIDUAL,
        "disagreement": 2.0**-8,
        "grace": GRACE,
    }
    return JointLimits(**(limits | changes))


def joint_settings(limits=None, **changes):
    settings = {
        "regulators": "regulators",
        "encoders": ENCODERS,
        "bore": 16e-3,
        "rod": 5e-3,
        "stroke": STROKE,
        "home": HOME,
        "moving_mass": 0.14,
        "base_pressure": BASE,
        "friction": JointFriction(7.0, 10.0, 8e-3, 50.0, 0.07, 0.11),
        "limits": limits or joint_limits(),
        "wire_stiffness": STIFF,
        # The deviation and its time alone: the other bounds have tests of their own.
        "alarms": JointAlarmSettings(pressure=PressureAlarm(40e3, 0.05, offset=250e3, slow=1e12)),
    }
    return JointSettings(**(settings | changes))


class JointBench:
    """A joint on devices of which each reads what a test says."""

    def __init__(self, settings=None, camera=None, regulators=None):
        self.regulators = regulators or FakeRegulators(CHANNELS)
        self.encoders = tuple(FakeEncoder(name) for name in ENCODERS)
        self.camera = camera
        self.stop = FakeStop()
        self.now = 0.0
        self.joint = SphericalJoint(
            settings or joint_settings(),
            regulators=self.regulators,
            encoders=self.encoders,
            camera=camera,
            emergency_stop=self.stop,
            period=PERIOD,
        )

    def place(self, rods):
        """Put the rods, m shorter than at home."""
        for encoder, rod in zip(self.encoders, rods, strict=True):
            encoder.extension = HOME - rod

    def lean(self, tilt, azimuth=0.4):
        self.place(rods_at(tilt, azimuth))

    def refresh(self, now):
        for device in (self.regulators, *self.encoders, self.stop):
            device.t = now

    def cycle(self, now):
        """Read and check, all readings of rods and pressures being of now."""
        self.refresh(now)
        state = self.joint.read(now)
        self.joint.check(state, now)
        return state

    def cycles(self, count, period=PERIOD):
        """Let so many cycles pass and return the last state."""
        for _ in range(count):
            self.now += period
            state = self.cycle(self.now)
        return state


class WireBench:
    """What watches the wires, told of rods every `STEP` seconds and never of a stretch."""

    STEP = 2.0**-8

    def __init__(self, residual=RESIDUAL, grace=GRACE, frozen=None, least_pull=55e3):
        self.watch = WireWatch(
            GEOMETRY,
            WireLimits(residual, grace, 0.03, 0.06, least_pull),
            frozen or FrozenAlarm(1.0, 1.0),
            ENCODERS,
            CHANNELS,
        )
        self.now = 0.0

    def check(self, rods, pressures=(BASE,) * 4, steps=1):
        self.now += steps * self.STEP
        self.watch.follow(rods, self.now)
        self.watch.check(rods, rods, pressures, self.now)
