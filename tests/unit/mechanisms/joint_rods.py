"""The watch of a joint whose rods a test moves."""

from joint_fakes import ENCODERS, joint_settings
from pneumatic_fakes import BASE, PERIOD

from controllers.spherical_joint.types import JointState
from rig.mechanisms.joint.watch import JointWatch


class Rods:
    """The watch of a joint that a test tells rods, and what a camera saw."""

    def __init__(self, camera=None, settings=None):
        self.watch = JointWatch(settings or joint_settings(), "regulators", ENCODERS, camera)
        self.now = 0.0

    def state(self, rods, sample=None, pressures=(BASE,) * 4):
        return JointState(self.now, tuple(rods), pressures, sample)

    def check(self, rods, sample=None, step=PERIOD, pressures=(BASE,) * 4):
        self.now += step
        state = self.state(rods, sample, pressures)
        self.watch.check(state, self.now)
        return state
