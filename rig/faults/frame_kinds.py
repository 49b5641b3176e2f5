"""What may happen to frames on a CAN bus, in either direction."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Literal

from rig.faults.kind import Expect, FaultKind, Magnitudes, Must, Place, Sizes, either, ride
from rig.faults.stage import Stage
from rig.faults.subject import Subject
from rig.hal.world import Frames

Way = Literal["to", "from", "alive", "sync"]

_SYNC = 0x080
_LASTING = Magnitudes(1e-3, 1.0, "s")
_PERHAPS_FOR_GOOD = Magnitudes(1e-3, 30.0, "s")
"""Of a cable that is off: for longer than any stop waits."""
_COMMANDS_LATE = 0.03
"""How long setpoints may be lost or late before it must be seen, s …"""
_ECHOED = 4.0
"""… and how many periods pass until a device has shown twice that it did not get them."""


def _ids(frames: Frames, way: Way) -> tuple[int, ...]:
    if way == "sync":
        return (_SYNC,)
    return {"to": frames.to_device, "from": frames.from_device, "alive": frames.alive}[way]


def _places(way: Way, subject: Subject) -> list[Place]:
    if way == "sync":
        synchronised = {f.bus for f in subject.frames.values() if _is_canopen(f)}
        return [
            Place(bus, bus, ("SYNC", *subject.words_of(bus)))
            for bus in subject.on_bus
            if bus in synchronised
        ]
    return [
        Place(device, device, (device, *_parts_of(device, subject), frames.bus))
        for device, frames in subject.frames.items()
        if _ids(frames, way) and "." not in device
    ]


def _parts_of(device: str, subject: Subject) -> tuple[str, ...]:
    """Return what else may be named for a device: its channels, and a contact that it reads."""
    reads_stop = "emergency_stop" in subject.knows.get(device, ())
    contact = ("emergency stop",) if reads_stop else ()
    return (*subject.channels.get(device, ()), *contact)


def _is_canopen(frames: Frames) -> bool:
    return any(can_id > 0x700 for can_id in frames.alive)


def _disturb(way: Way, kind: str, stage: Stage, place: Place, sizes: Sizes) -> Callable[[], None]:
    world = stage.world
    if way == "sync":
        ends = [world.disturb(place.target, kind, _SYNC, sizes.magnitude or 0.0)]
    else:
        frames = world.frames_of(place.target)
        assert frames is not None
        changed = stage.changed if way == "to" else None
        ends = [
            world.disturb(frames.bus, kind, can_id, sizes.magnitude or 0.0, changed)
            for can_id in _ids(frames, way)
        ]
    return partial(_end_all, ends)


def _end_all(ends: Sequence[Callable[[], None]]) -> None:
    for end in ends:
        end()


def _unless_bridged(sizes: Sizes, subject: Subject) -> Must:
    return Must.SAFE if sizes.lasts > 3.0 * subject.reading_age else Must.EITHER


def _unless_short(sizes: Sizes, subject: Subject) -> Must:
    """Expect what lasts longer than is bridged, and than it takes to be sent, echoed, confirmed."""
    least = _COMMANDS_LATE + _ECHOED * subject.period
    return Must.SAFE if sizes.lasts > least else Must.EITHER


def _unless_unconfirmed(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a wrong byte of setpoints is seen where every device sends it back."""
    byte = int(sizes.magnitude or 0.0)
    told = [
        subject.confirming.get(device, (False,))
        for device, frames in subject.frames.items()
        if frames.to_device
    ]
    is_seen = all(confirmed[byte % len(confirmed)] for confirmed in told)
    return _unless_short(sizes, subject) if is_seen else Must.EITHER


def _unless_unshown(sizes: Sizes, subject: Subject) -> Must:
    """Expect that late setpoints are seen where every device says which one it got."""
    told = {device for device, frames in subject.frames.items() if frames.to_device}
    late = _unless_early(_COMMANDS_LATE)(sizes, subject)
    return late if told <= subject.confirming.keys() else Must.EITHER


def _unless_early(least: float) -> Expect:
    return lambda sizes, subject: (
        Must.SAFE if (sizes.magnitude or 0.0) > least and sizes.lasts > 2.0 * least else Must.EITHER
    )


def _unless_fresh(sizes: Sizes, subject: Subject) -> Must:
    return _unless_early(subject.reading_age + 2.0 * subject.period)(sizes, subject)


def _kind(name: str, what: str, way: Way, kind: str, must: Expect, within: float, *,
          why: str = "", magnitude: Magnitudes | None = None,
          lasts: Magnitudes | None = _LASTING,
          forgives: frozenset[str] = frozenset()) -> FaultKind:  # fmt: skip
    return FaultKind(
        name=name, what=what, places=partial(_places, way), apply=partial(_disturb, way, kind),
        must=must, within=within, why=why, magnitude=magnitude, lasts=lasts, forgives=forgives,
        in_setpoints=way == "to",
    )  # fmt: skip


_BRIDGED = "a gap within the age that a reading may have is bridged"
_SHORT = "setpoints that are late for less are caught up"
_ANOTHERS = frozenset({"fall"})
"""What drives do that somebody else commands: a robot that is told to kneel does not stand."""
_WRONG_ANGLE = frozenset({"fall", "rate"})
"""What a drive does that obeys a setpoint which was another one on its way."""
_DELAY = Magnitudes(1e-3, 50e-3, "s")
_BYTE = Magnitudes(1.0, 7.0, "1")

KINDS = (
    _kind("readings_lost", "What a device measures does not arrive.", "from", "drop",
          _unless_bridged, 0.1, why=_BRIDGED),
    _kind("readings_late", "What a device measures comes late.", "from", "delay",
          _unless_fresh, 0.2, why=_BRIDGED, magnitude=_DELAY),
    _kind("readings_twice", "What a device measures comes twice.", "from", "duplicate",
          either, 0.1, why="the second copy says nothing new"),
    _kind("readings_out_of_order", "Every other reading comes after its successor.", "from",
          "reorder", either, 0.2, why="the older one is older than it looks by one cycle",
          magnitude=Magnitudes(0.2e-3, 2e-3, "s")),
    _kind("readings_short", "What a device measures ends after some bytes.", "from", "truncate",
          _unless_bridged, 0.1, why=_BRIDGED, magnitude=_BYTE),
    _kind("readings_corrupt", "A byte of what a device measures is inverted.", "from", "corrupt",
          either, 0.1, why="a byte that says little changes little", magnitude=_BYTE),
    _kind("readings_spoofed", "Somebody else sends under a device's identifier.", "from",
          "spoof", _unless_bridged, 0.1, why=_BRIDGED),
    _kind("setpoints_lost", "Setpoints do not arrive.", "to", "drop", _unless_short, 0.2,
          why=_SHORT),
    _kind("setpoints_late", "Setpoints arrive late.", "to", "delay",
          _unless_unshown, 0.2, why=_SHORT + "; where no echo shows it, the joint lags by its "
          "speed times the delay, within its following window", magnitude=_DELAY),
    _kind("setpoints_corrupt", "A byte of the setpoints is inverted.", "to", "corrupt",
          _unless_unconfirmed, 0.2, magnitude=_BYTE, forgives=_WRONG_ANGLE,
          why="as setpoints that are late; where no echo shows it, a low byte is 3.9 kPa of the "
          "joint's 500 and 3 mrad of a leg's servo, less than those may be off; the byte of "
          "digital outputs shuts the supply valve, which the chambers show when they lack air"),
    _kind("setpoints_short", "Setpoints end after some bytes.", "to", "truncate",
          _unless_short, 0.2, why=_SHORT, magnitude=_BYTE),
    _kind("setpoints_twice", "Setpoints arrive twice.", "to", "duplicate", ride, 0.1,
          why="the second copy asks for nothing new"),
    _kind("setpoints_out_of_order", "Every other setpoint arrives after its successor.", "to",
          "reorder", either, 0.2, why="the older one acts for one cycle at most",
          magnitude=Magnitudes(0.2e-3, 2e-3, "s")),
    _kind("setpoints_spoofed", "Somebody else sends under the setpoints' identifier.", "to",
          "spoof", _unless_bridged, 0.05, why=_BRIDGED, forgives=_ANOTHERS),
    _kind("heartbeats_lost", "A device's heartbeats do not arrive.", "alive", "drop", either, 0.3,
          why="a device that measures is alive", lasts=_LASTING),
    _kind("sync_lost", "SYNC does not arrive.", "sync", "drop", _unless_bridged, 0.1,
          why=_BRIDGED, lasts=_PERHAPS_FOR_GOOD),
)  # fmt: skip
