"""Hazards that nothing could have kept off: where they are forgiven, and why."""

from collections.abc import Mapping

import numpy as np

from rig.faults.kind import Plight
from rig.faults.subject import Subject

_LATE_CYCLES = 3
"""Read in one, told in the next, obeyed by the end of the third: what breaks later, nobody sees."""
_SHOWS = 5e-3
"""rad of motion before a frozen or mirrored encoder shows: sag and rounding are less."""
_ROOM = 0.3
"""rad: by so much a servo of legs may be told another angle for the one where it stands, since
its own limits are no nearer; a jump that goes beyond them turns the joint by the rest."""
ON_A_WIRE = frozenset({"position", "speed", "tilt", "tension", "end stop hit"})
"""What a wire that lets go does before anybody can act: the mechanical stop bears it."""
_TOPPLING_PUSH = 0.3
"""N s: moves the mass of the legs by 50 mm/s and their capture point by 8 mm, which is all the
margin that a step may have."""
_OVERPOWERING = 10.0
"""N s, 100 N for a tenth of a second: at arm's length half of what the strongest drive can hold."""
_OTHER = {"left": "right", "right": "left"}
_HOLDS = 50e3
"""Pa gauge: what is in a chamber that pulls more than its seals hold."""
TUBE = 1.5e-8
"""m3/(s Pa): lets more out of a chamber than its regulator can feed; 3.5 mm wide."""
_FLOW = 2.7e-3
"""m3/s: what a hole lets out, whose opponent throws the pair at its end. The emergency stop in the
very instant keeps a pair within its margin up to 3.2e-3; half a millimetre of motion, by which
anybody sees it, takes 8 ms, and leaves this."""
_OVERPOWERING_WIRES = 2.0
"""N s, 20 N for a tenth of a second: as much as chambers can pull that have …"""
_GIVES = 110e3
"""… so much to give, Pa gauge. With less they pull less."""


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


def drops_a_leg(plight: Plight) -> frozenset[str]:
    """Forgive a fall where the leg that bears the weight has a joint without torque.

    On both feet the other leg holds, until the waist is over the ankle of the one that lets go,
    or unless a joint of its own has no torque by an earlier fault.
    """
    leg = plight.place.axis.partition("_")[0]
    loads = {name for name, load in plight.truth.items() if name.startswith("load_") and load > 0.0}
    is_over = _way_to(leg, plight.truth) >= 1.0 or _is_limp(_OTHER.get(leg, ""), plight.truth)
    return frozenset({"fall", "rate"}) if is_over or loads == {f"load_{leg}"} else frozenset()


def _is_limp(leg: str, truth: Mapping[str, float]) -> bool:
    """Return whether some joints of a leg have no torque; without any at all nobody stood on it."""
    powered = [value for name, value in truth.items() if name.startswith(f"powered_{leg}_")]
    return 0.0 in powered and any(powered)


def _way_to(leg: str, truth: Mapping[str, float]) -> float:
    """Return how far the waist is over to a leg: 0 over the other one's ankle, 1 over its own."""
    other = _OTHER.get(leg)
    if f"{leg}_foot_y" not in truth:
        return 0.0
    here, there, waist = (
        np.array([truth[f"{part}_{axis}"] for axis in "xy"])
        for part in (f"{leg}_foot", f"{other}_foot", "waist")
    )
    return float((waist - there) @ (here - there) / ((here - there) @ (here - there)))


def lets_fall_unseen(plight: Plight) -> frozenset[str]:
    """Forgive a fall as `lets_fall` does, and where the axis rested until the program ended."""
    return frozenset({"fall", "rate"}) if plight.moved < _SHOWS else lets_fall(plight)


def lets_fall_far(plight: Plight) -> frozenset[str]:
    """Forgive a fall as `lets_fall` does, if the jump is beyond what can be made up for."""
    is_far = abs(plight.sizes.magnitude or 0.0) > _ROOM
    is_late = plight.left < _LATE_CYCLES * plight.subject.period
    return lets_fall(plight) if is_far or is_late else frozenset()


def topples(plight: Plight) -> frozenset[str]:
    """Forgive a fall after a push that legs cannot stand which know nothing of it."""
    too_much = abs(plight.sizes.magnitude or 0.0) > _TOPPLING_PUSH
    return frozenset({"fall"}) if too_much else frozenset()


def overpowers(plight: Plight) -> frozenset[str]:
    """Forgive speeds and ways of axes whose drives are weaker than who pushes."""
    too_much = abs(plight.sizes.magnitude or 0.0) > _OVERPOWERING
    return frozenset({"rate", "range"}) if too_much else frozenset()


def overpowers_wires(plight: Plight) -> frozenset[str]:
    """Forgive what a push does that is stronger than the chambers: the mechanical stop bears it.

    Empty ones hold nothing, and a rod that is thrown in compresses what is in its chamber.
    """
    pressures = [value for name, value in plight.truth.items() if name.startswith("pressure_")]
    weakest = min(pressures)
    too_much = abs(plight.sizes.magnitude or 0.0) > _OVERPOWERING_WIRES * min(weakest / _GIVES, 1.0)
    is_thrown = too_much or weakest < _HOLDS
    return ON_A_WIRE | {"energy left"} if is_thrown else frozenset()


def pulls_alone(plight: Plight) -> frozenset[str]:
    """Forgive what a regulator that stays at a pressure does when all others are vented.

    Up to 50 kPa its chamber pulls no more than its seals hold, and up to the bound of pressures it
    does nothing that a pressure which was asked for would not.
    """
    pressure = plight.sizes.magnitude or 0.0
    most = min(hazard.high for hazard in plight.subject.hazards if hazard.name == "pressure")
    found = ON_A_WIRE if pressure > _HOLDS else frozenset()
    return found | {"pressure"} if pressure > most else found


def empties_at_once(plight: Plight) -> frozenset[str]:
    """Forgive what a chamber does that is empty before its opponents can be.

    Through a tube of 3.5 mm it loses half of its pressure in 4 ms, and a regulator takes 17 ms:
    that is a wire cut a little more slowly, with less energy for the mechanical stop. At high
    pressures a narrower one does it. Where no opponent pulls more than seals hold, nothing is
    forgiven.
    """
    most = max(value for name, value in plight.truth.items() if name.startswith("pressure_"))
    width = plight.sizes.magnitude or 0.0
    wide = width >= TUBE or width * most > _FLOW
    return ON_A_WIRE if wide and most > _HOLDS else frozenset()


def has_valves(subject: Subject) -> bool:
    """Return whether proportional valves feed the chambers, and no regulators."""
    return "valve_stuck" in subject.knows.get("plant", ())


def fills_alone(plight: Plight) -> frozenset[str]:
    """Forgive what a signal does that stays: a spool stays open, a regulator holds its pressure.

    A regulator does so until the supply has let its air out, when all others are empty long since:
    see `pulls_alone`.
    """
    if has_valves(plight.subject):
        return ON_A_WIRE | {"pressure"}
    held = [plight.truth.get(f"pressure_{name}", 0.0) for name in plight.place.names]
    return ON_A_WIRE if max(held) > _HOLDS else frozenset()


def falls(plight: Plight) -> frozenset[str]:
    """Forgive what an axis does whose brake is broken while its drive has no torque."""
    return frozenset({"rate", "range"}) if plight.limp else frozenset()
