"""Every kind of fault by name, and those that a rig can suffer."""

from rig.faults import frame_kinds, program_kinds, world_kinds
from rig.faults.kind import FaultKind, Place, ride
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
    for kind in (NOTHING, *world_kinds.KINDS, *frame_kinds.KINDS, *program_kinds.KINDS)
}


def kinds_for(subject: Subject) -> dict[str, FaultKind]:
    """Return those that have a place on a rig."""
    return {name: kind for name, kind in KINDS.items() if kind.places(subject)}
