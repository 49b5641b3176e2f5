"""How far a motion goes, in the words of the log."""

import copy
from typing import Final

from rig.assembly import Backend, build_rig
from rig.experiment.plan import Plan
from rig.hal import Column

_INSTANTS: Final = 400
"""At which a motion is looked at, but for one whose rows are told cycle by cycle."""
_REFERENCE: Final = "reference."


def extent_of(plan: Plan) -> list[tuple[Column, float, float]]:
    """Return the least and the greatest value of each column of the reference that changes.

    Parameters
    ----------
    plan : Plan
        It is not followed: nothing moves, not even in simulation.
    """
    motion = plan.motion.foreseen
    with build_rig(plan.profile, Backend.SIM) as rig:
        mechanism = rig.mechanism
        mechanism.attach(copy.copy(plan.controller), motion)
        state = mechanism.read(rig.clock.now())
        command = mechanism.released_command()
        cycles = round(motion.duration / plan.profile.loop.period)
        count = cycles if motion.waits else _INSTANTS
        rows = [
            mechanism.row(state, motion.at(k * motion.duration / count), command, command)
            for k in range(count + 1)
        ]
        columns = zip(mechanism.columns, zip(*rows, strict=True), strict=True)
        return [
            (column, min(values), max(values))
            for column, values in columns
            if column.name.startswith(_REFERENCE) and min(values) < max(values)
        ]
