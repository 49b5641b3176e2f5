"""How far the joints of a simulated rig truly turn while somebody tests it."""

import random

from rig.assembly import Backend, build_rig


class WatchedJoints:
    """A simulated world whose joints are looked at every two milliseconds."""

    def __init__(self, world, seen):
        self._world = world
        self._seen = seen
        names = list(world.plant.channel_names)
        self._columns = [k for k, (n, _) in enumerate(world.plant.truth_columns) if n in names]
        self._first = world.plant.truth()

    def __getattr__(self, name):
        return getattr(self._world, name)

    def advance(self, t):
        while self._world.time < t:
            self._world.advance(min(t, self._world.time + 2e-3))
            truth = self._world.plant.truth()
            way = max(abs(truth[k] - self._first[k]) for k in self._columns)
            self._seen["angle"] = max(self._seen["angle"], way)


def rig_with(seen, plant=None, seed=0):
    """Return what builds a rig with a defect, and looks at the truth of it."""

    def make(its):
        rig = build_rig(its, Backend.VIRTUAL)
        if plant is not None:
            plant(rig, random.Random(f"{plant.__name__} {seed}"))
        rig.clock.world = WatchedJoints(rig.clock.world, seen)
        return rig

    return make
