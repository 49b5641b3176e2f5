"""Where a servo whose encoder lies lets legs fall, and nothing could have held them."""

from rig.faults.kind import Plight

_LATE_CYCLES = 3
"""Read in one, told in the next, obeyed by the end of the third: what breaks later, nobody sees."""
_SHOWS = 5e-3
"""rad of motion before a frozen or mirrored encoder shows: sag and rounding are less."""
_ROOM = 0.3
"""rad: by so much a servo of legs may be told another angle for the one where it stands, since
its own limits are no nearer; a jump that goes beyond them turns the joint by the rest."""


def lets_fall(plight: Plight) -> frozenset[str]:
    """Forgive a fall where a leg bears that one of its joints cannot hold, or nobody is there.

    A servo with one loop on one encoder follows its lie for as long as it has torque; without
    torque a standing leg folds.
    """
    if plight.left < _LATE_CYCLES * plight.subject.period:
        return frozenset({"fall", "rate"})
    leg = plight.place.axis.partition("_")[0]
    bears = plight.truth.get(f"load_{leg}", 0.0) > 0.0
    helpless = plight.place.target not in plight.subject.by_velocity
    return frozenset({"fall"}) if bears and helpless else frozenset()


def lets_fall_unseen(plight: Plight) -> frozenset[str]:
    """Forgive a fall as `lets_fall` does, and where the axis rested until the program ended."""
    return frozenset({"fall", "rate"}) if plight.moved < _SHOWS else lets_fall(plight)


def lets_fall_far(plight: Plight) -> frozenset[str]:
    """Forgive a fall as `lets_fall` does, if the jump is beyond what can be made up for."""
    is_far = abs(plight.sizes.magnitude or 0.0) > _ROOM
    is_late = plight.left < _LATE_CYCLES * plight.subject.period
    return lets_fall(plight) if is_far or is_late else frozenset()
