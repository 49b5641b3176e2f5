"""The first motion of axes under control: each by a degree and back."""

from math import radians
from typing import Final

from rig.assembly import REGISTRY
from rig.commissioning.steps.motion import Planned
from rig.config import Profile, ReferenceEntry
from rig.mechanisms.servo.calibration.posture_moves import Postures, PostureScript

TRAVEL: Final = radians(1.0)
"""Of each axis, rad."""
_SPEED: Final = radians(5.0)
"""With which it goes at most, rad/s."""


def axis_by_axis(profile: Profile) -> Planned:
    """Return the motion of each axis alone, there and back, from where they stand."""
    settings = profile.mechanism_settings
    view = REGISTRY.load("mechanism", profile.mechanism)
    axes = view.axis_limits(settings)
    still = (0.0,) * len(axes.names)
    stands: list[tuple[str, tuple[float, ...]]] = [("start", still)]
    for k, name in enumerate(axes.names):
        there = tuple(TRAVEL if j == k else 0.0 for j in range(len(axes.names)))
        stands += [(name, there), (f"{name} back", still)]
    postures = Postures(
        names=tuple(name for name, _ in stands), joints=axes.names,
        angles=tuple(angles for _, angles in stands), dwell=0.5, judged=0.2, relative=True,
    )  # fmt: skip
    script = PostureScript(
        postures, [min(_SPEED, rate) for rate in axes.rates],
        list(zip(axes.lower, axes.upper, strict=True)),
        reference=view.kinds.reference, command=view.kinds.command,
    )  # fmt: skip
    law = next(iter(profile.controllers))
    return Planned(ReferenceEntry("postures", postures), law, script, script)
