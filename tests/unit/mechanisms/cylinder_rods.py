"""The watch of a pair whose rods a test moves."""

from pneumatic_fakes import (
    BASE,
    HOME,
    PERIOD,
    SPEED,
    pair_limits,
    pair_settings,
)

from controllers.cylinder.types import PairState
from rig.mechanisms.cylinder.settings import PairAlarmSettings, RodsAlarm
from rig.mechanisms.cylinder.watch import PairWatch
from rig.mechanisms.pneumatic.alarms.settings import FrozenAlarm, SwappedAlarm

NAMES = "encoder-agonist", "encoder-antagonist"
CHANGE = 2.0**-12
WIDE = 2.0**-5
"""A mismatch that no test here reaches."""
NEVER = FrozenAlarm(WIDE, 1e6)


class Rods:
    """The watch of a pair of which a test says where each rod is, from home, m."""

    def __init__(self, change=WIDE, mismatch=WIDE, frozen=NEVER, swapped=WIDE, **settings):
        alarms = PairAlarmSettings(
            frozen=frozen, rods=RodsAlarm(change), swapped=SwappedAlarm(distance=swapped)
        )
        limits = pair_limits(mismatch=mismatch, speed=SPEED)
        self.settings = pair_settings(limits, alarms=alarms, **settings)
        self.watch = PairWatch(self.settings, "regulators", NAMES)
        self.now = 0.0

    def cycle(self, agonist, antagonist, pressures=(BASE, BASE), step=PERIOD):
        self.now += step
        state = PairState(self.now, 0.0, *pressures)  # its speed is another test's
        self.watch.check(state, (HOME + agonist, HOME + antagonist), self.now)

    def settle(self, pressures=(BASE, BASE)):
        """Let the wires be taut for long enough that the rods' agreement is the usual one."""
        for _ in range(128):
            self.cycle(0.0, 0.0, pressures)
