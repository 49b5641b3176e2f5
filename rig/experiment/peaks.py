"""How fast a reference is at most: what limits of speed and acceleration are held against."""

from typing import Final, NamedTuple

from rig.assembly import REGISTRY, check_profile
from rig.experiment.plan import Plan

_MOST: Final = 20_000
"""Instants that a reference is looked at."""
_PEAKS: Final = {"velocity": "speed", "acceleration": "acceleration"}
"""Fields of a reference that is a number over time, and what a limit of each is called."""


class Peak(NamedTuple):
    """The greatest size of a quantity of a reference.

    Parameters
    ----------
    what : str
        ``speed`` or ``acceleration``.
    value : float
        In `unit`.
    unit : str
        SI.
    at : float
        When it is, s.
    limit : float or None
        The profile's ``limits`` of the same name, if it has one.
    """

    what: str
    value: float
    unit: str
    at: float
    limit: float | None


def peaks_of(plan: Plan) -> list[Peak]:
    """Return the peaks of a motion whose reference is one number and its rates; else nothing."""
    motion = plan.motion.foreseen
    units = {column.name: column.unit for column in check_profile(plan.profile)}
    fields = [
        field
        for field in _PEAKS
        if f"reference.{field}" in units and isinstance(getattr(motion.at(0.0), field, None), float)
    ]
    count = min(_MOST, int(motion.duration / plan.profile.loop.period)) + 1
    times = [motion.duration * k / max(count - 1, 1) for k in range(count)]
    mechanism = REGISTRY.load("mechanism", plan.profile.mechanism)
    limits = mechanism.limits_of(plan.profile.mechanism_settings)
    found = []
    references = [motion.at(t) for t in times] if fields else []
    for field in fields:
        value, at = max(
            (abs(getattr(reference, field)), t)
            for reference, t in zip(references, times, strict=True)
        )
        limit = getattr(limits, _PEAKS[field], None)
        found.append(Peak(_PEAKS[field], value, units[f"reference.{field}"], at, limit))
    return found
