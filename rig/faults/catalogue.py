"""Every kind of fault by name, and those that a rig can suffer."""

from functools import partial

from rig.faults import (
    body_kinds,
    frame_kinds,
    interface_kinds,
    program_kinds,
    servo_kinds,
    valve_kinds,
    world_kinds,
)
from rig.faults.kind import FaultKind, Place, Sizes, either, ride
from rig.faults.stage import Stage
from rig.faults.subject import Subject

NOTHING = FaultKind(
    name="nothing",
    what="Nothing breaks: a stop here is a false one.",
    places=lambda subject: [Place("nothing", "nothing", ())],
    apply=lambda stage, place, sizes: None,
    must=ride,
)

KINDS = {
    kind.name: kind
    for kind in (
        NOTHING,
        *world_kinds.KINDS,
        *servo_kinds.KINDS,
        *interface_kinds.KINDS,
        *valve_kinds.KINDS,
        *body_kinds.KINDS,
        *frame_kinds.KINDS,
        *program_kinds.KINDS,
    )
}


_NEEDS = (
    (world_kinds.PNEUMATIC, "a simulated chamber, wire, regulator or supply"),
    (valve_kinds.KINDS, "proportional valves"),
    (body_kinds.KINDS, "load cells under its feet and an inertial sensor at its waist"),
    (world_kinds.EMERGENCY_STOPS, "a device that reads the contact"),
    (world_kinds.SENSORS, "a linear encoder that knows it"),
    (world_kinds.CAMERAS, "a camera"),
    (world_kinds.NODES, "a device that knows it: what its protocol has no word for, it cannot do"),
    (servo_kinds.KINDS, "a drive that knows it: what its protocol has no word for, it cannot do"),
    (world_kinds.SURROUNDINGS, "a robot that stands, or has a hand"),
    (interface_kinds.KINDS, "an interface of that kind"),
    (frame_kinds.KINDS, "cyclic CAN frames"),
)


def refused_for(subject: Subject) -> dict[str, str]:
    """Return what a rig cannot suffer, and what it lacks for that."""
    possible = kinds_for(subject)
    return {
        kind.name: needs for kinds, needs in _NEEDS for kind in kinds if kind.name not in possible
    }


def kind_named(name: str) -> FaultKind:
    """Return a kind; a name that is not ours is what somebody's plant calls a fault of its own."""
    return KINDS.get(name) or FaultKind(
        name=name,
        what="The rig's own plant knows what breaks.",
        places=partial(_of_plant, name),
        apply=partial(_inject, name),
        must=either,
        why="only its hazards say what must not come of it",
    )


def kinds_for(subject: Subject) -> dict[str, FaultKind]:
    """Return those that have a place on a rig, and what its plant can suffer beside them."""
    ours = {name: kind for name, kind in KINDS.items() if kind.places(subject)}
    used = {place.target for kind in ours.values() for place in kind.places(subject)}
    if "plant" in used:  # one of ours, whose faults have rows
        return ours
    own = [name for name in subject.knows.get("plant", ()) if name != "repair"]
    return ours | {name: kind_named(name) for name in own if name not in KINDS}


def _of_plant(name: str, subject: Subject) -> list[Place]:
    return [Place("plant", "plant", ("",))] if name in subject.knows.get("plant", ()) else []


def _inject(name: str, stage: Stage, place: Place, sizes: Sizes) -> None:
    stage.world.inject(place.target, name)
