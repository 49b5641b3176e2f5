"""The acceptance test of the spherical joint.

It has no first motion: with half of the pressure, which a rig has until then, wires of the
simulated joint go slack.
"""

from collections.abc import Sequence

from rig.commissioning.step import AcceptanceStep
from rig.mechanisms.pneumatic.commissioning.course import pneumatic_course


def steps() -> Sequence[AcceptanceStep]:
    """Return the steps in their order."""
    return pneumatic_course()
