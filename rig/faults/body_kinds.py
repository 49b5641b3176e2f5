"""What may break of the sensors that legs balance by; their nodes are in `world_kinds`.

Corrections of balance stay within the plan's margin, whatever is felt, so that a sensor that lies
must not make anything fall. What a cell or a waist alone can be seen to do wrong stops the run.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from rig.faults.kind import FaultKind, Magnitudes, Must, Place, Sizes, ride, safe
from rig.faults.subject import Subject
from rig.faults.world_kinds import inject, of_device

_CELL = ("feet", "load cell")
_BOUNDED = "what it lies moves the waist within the margin that the plan has to spare"
_UNHEEDED = "the lean only says whether the sensors are believed; if not, nothing is corrected"
_FAR_FROM_END = 40.0
"""N: so much beside the load of a step leaves a cell of 100 N within its range."""
_BEYOND_END = 150.0
"""N: is beyond it, whatever the cell bears."""


def _ends_beyond_range(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a cell is seen that is pushed to the end of its range, and that less is none."""
    size = abs(sizes.magnitude or 0.0)
    if size >= _BEYOND_END:
        return Must.SAFE
    return Must.RIDE if size <= _FAR_FROM_END else Must.EITHER


def _whole(known: str, sensor: str, subject: Subject) -> list[Place]:
    """Return the devices to one of which a sensor of the plant belongs; all of them break."""
    if known not in subject.knows.get("plant", ()):
        return []
    devices = tuple(
        device
        for device, channels in subject.channels.items()
        if device != "plant" and any(channel.startswith(sensor) for channel in channels)
    )
    return [Place("plant", " ".join(devices), devices)] if devices else []


def _felt(places: Callable[[Subject], Sequence[Place]], subject: Subject) -> list[Place]:
    """Return the places of those sensors that a device of the rig reads."""
    devices = [names for device, names in subject.channels.items() if device != "plant"]
    read = {channel for names in devices for channel in names}
    return [place for place in places(subject) if not place.axis or place.axis in read]


_ROWS = (
    FaultKind(name="feet_frozen", what="All load cells repeat what they bear.",
              places=partial(_whole, "feet_frozen", "right_front"),
              apply=partial(inject, "feet_frozen"),
              must=safe, within=0.3),
    FaultKind(name="waist_frozen", what="The inertial sensor repeats how it leans and turns.",
              places=partial(_whole, "waist_frozen", "waist_"),
              apply=partial(inject, "waist_frozen"), must=safe, within=0.3),
    of_device("cell_frozen", "A load cell repeats what it bears.", safe, 0.3, _CELL),
    of_device("cell_offset", "A load cell jumps and stays off.", _ends_beyond_range, 0.3, _CELL,
              magnitude=Magnitudes(0.5, 300.0, "N", signed=True),
              why=f"{_BOUNDED}; beyond 40 N, it depends on its load whether it is at its end"),
    of_device("cell_scale", "A load cell shows so many times what it bears.", ride, 1.0, _CELL,
              magnitude=Magnitudes(0.02, 2.0, "1"), why=_BOUNDED),
    of_device("cell_noisy", "A load cell scatters.", ride, 1.0, _CELL,
              magnitude=Magnitudes(0.5, 50.0, "N"), why=_BOUNDED),
    of_device("lean_frozen", "One angle of the waist repeats its value.", ride, 1.0,
              ("waist",), why=_UNHEEDED),
    of_device("lean_offset", "One angle of the waist jumps and stays off.", ride, 1.0, ("waist",),
              magnitude=Magnitudes(5e-3, 1.5, "rad", signed=True), why=_UNHEEDED),
    of_device("lean_noisy", "One angle of the waist scatters.", ride, 1.0, ("waist",),
              magnitude=Magnitudes(2e-3, 0.3, "rad"), why=_UNHEEDED),
    of_device("gyro_frozen", "One rate of the waist repeats its value.", ride, 1.0,
              ("waist",), why=_BOUNDED),
    of_device("gyro_offset", "One rate of the waist jumps and stays off.", ride, 1.0, ("waist",),
              magnitude=Magnitudes(5e-3, 2.0, "rad/s", signed=True), why=_BOUNDED),
    of_device("gyro_scale", "One rate of the waist is so many times the true one.", ride, 1.0,
              ("waist",), magnitude=Magnitudes(0.02, 10.0, "1"), why=_BOUNDED),
    of_device("gyro_noisy", "One rate of the waist scatters.", ride, 1.0, ("waist",),
              magnitude=Magnitudes(0.01, 1.0, "rad/s"), why=_BOUNDED),
)  # fmt: skip

KINDS = tuple(replace(row, places=partial(_felt, row.places)) for row in _ROWS)
