"""Ask a CANopen bus who is there, without disturbing it.

Only objects are read (0x1000, 0x1018) and heartbeats heard: no node is reset, started or
configured. A node in STOPPED answers no question, and every run leaves its nodes so: those that
are expected and say nothing are taken to PRE-OPERATIONAL, where outputs stay safe as well. So are
those that answer, if nobody uses the bus: the other one of two with one number may be STOPPED.

A device that hears and never sends is nobody to a bus; no question finds it.

References
----------
CiA 301 V4.2, sections 7.2.4.3 (SDO upload), 7.5.2.1 and 7.5.2.19 (objects).
"""

import struct
from collections import defaultdict
from collections.abc import Collection
from typing import Final

from drivers.canopen.heartbeat import NmtState, describe_state
from rig.hal import Clock, FastCanBus
from rig.hal.frames import Found

_NMT_ID: Final = 0x000
_ENTER_PRE_OPERATIONAL: Final = 0x80
_UPLOAD: Final = 0x40
_EXPEDITED: Final = 0x43  # with four bytes of data
_ABORT: Final = 0x80
_DEVICE_TYPE: Final = (0x1000, 0)
_VENDOR, _PRODUCT, _SERIAL = (0x1018, 1), (0x1018, 2), (0x1018, 4)
_Object = tuple[int, int]
_AT_ONCE: Final = 8  # questions; an interface's queue may hold no more than ten frames
_PAUSE: Final = 2e-3  # between them, s
_ANSWER_TIME: Final = 0.3  # s
_AFTERWARDS: Final = 0.02  # for a second answer to the same question, s
_REQUEST: Final = struct.Struct("<BHB4x")
_ANSWER: Final = struct.Struct("<BHBI")


class _Heard:
    """The frames that came in, sorted."""

    def __init__(self) -> None:
        self.objects: dict[int, dict[_Object, list[int | None]]] = defaultdict(
            lambda: defaultdict(list)
        )
        self.states: dict[int, int] = {}
        self.in_use = False  # somebody runs, or is run

    def take(self, can_id: int, data: bytes) -> None:
        if 0x581 <= can_id <= 0x5FF and len(data) == 8:
            command, index, sub, value = _ANSWER.unpack(data)
            if command in (_EXPEDITED, _ABORT):
                answer = value if command == _EXPEDITED else None
                self.objects[can_id - 0x580][index, sub].append(answer)
        elif 0x701 <= can_id <= 0x77F and len(data) == 1:
            state = self.states[can_id - 0x700] = data[0] & 0x7F
            self.in_use |= state == NmtState.OPERATIONAL
        else:
            self.in_use = True


def survey_canopen(
    bus: FastCanBus, clock: Clock, expected: Collection[int] = (), *, listen: float = 1.0
) -> list[Found]:
    """Return who answers on an open bus, by node number.

    Parameters
    ----------
    bus : FastCanBus
        Open; nobody else reads it.
    clock : Clock
        For pauses.
    expected : collection of int
        Node numbers that should be there.
    listen : float
        How long heartbeats are waited for at least, s.

    Raises
    ------
    OSError, can.CanError
        The interface refuses frames.
    """
    heard = _Heard()
    until = clock.now() + listen
    _ask(bus, clock, heard, range(1, 128), _DEVICE_TYPE)
    silent = tuple(node for node in expected if not heard.objects[node][_DEVICE_TYPE])
    _wake_and_ask(bus, clock, heard, silent)
    for thing in (_VENDOR, _PRODUCT, _SERIAL):
        answered = tuple(node for node, objects in heard.objects.items() if objects[_DEVICE_TYPE])
        _ask(bus, clock, heard, answered, thing)
    _listen(bus, clock, heard, until)
    if not heard.in_use:
        _wake_and_ask(bus, clock, heard, tuple(node for node in expected if node not in silent))
    _ask_twins_again(bus, clock, heard)
    asked = {node for node, objects in heard.objects.items() if any(objects.values())}
    return [_describe(node, heard) for node in sorted({*asked, *heard.states})]


def _ask(
    bus: FastCanBus, clock: Clock, heard: _Heard, nodes: range | tuple[int, ...], thing: _Object
) -> None:
    send = bus.send_data
    for number, node in enumerate(nodes):
        send(0x600 + node, _REQUEST.pack(_UPLOAD, *thing))
        if number % _AT_ONCE == _AT_ONCE - 1:
            _listen(bus, clock, heard, clock.now() + _PAUSE)
    if not nodes:
        return
    until = clock.now() + _ANSWER_TIME
    while clock.now() < until and not all(heard.objects[node][thing] for node in nodes):
        _listen(bus, clock, heard, clock.now() + _PAUSE)
    _listen(bus, clock, heard, clock.now() + _AFTERWARDS)


def _wake_and_ask(bus: FastCanBus, clock: Clock, heard: _Heard, nodes: tuple[int, ...]) -> None:
    """Take nodes to PRE-OPERATIONAL and ask what they are; what they said before is forgotten."""
    for node in nodes:
        bus.send_data(_NMT_ID, bytes((_ENTER_PRE_OPERATIONAL, node)))
        _listen(bus, clock, heard, clock.now() + _PAUSE)
    before = {node: heard.objects[node].pop(_DEVICE_TYPE, []) for node in nodes}
    _ask(bus, clock, heard, nodes, _DEVICE_TYPE)
    for node, answers in before.items():
        if len(answers) > len(heard.objects[node][_DEVICE_TYPE]):
            heard.objects[node][_DEVICE_TYPE] = answers


def _ask_twins_again(bus: FastCanBus, clock: Clock, heard: _Heard) -> None:
    """Ask once more who answered twice: one may be a late answer to the question before.

    Two devices with one number answer twice again.
    """
    before = {
        node: objects.pop(_DEVICE_TYPE)
        for node, objects in heard.objects.items()
        if len(objects[_DEVICE_TYPE]) > 1
    }
    _ask(bus, clock, heard, tuple(before), _DEVICE_TYPE)
    for node, answers in before.items():
        if not heard.objects[node][_DEVICE_TYPE]:
            heard.objects[node][_DEVICE_TYPE] = answers


def _listen(bus: FastCanBus, clock: Clock, heard: _Heard, until: float) -> None:
    while True:
        for can_id, data in bus.drain(256):
            heard.take(can_id, data)
        now = clock.now()
        if now >= until:
            return
        clock.sleep_until(min(now + _PAUSE, until))


def _describe(node: int, heard: _Heard) -> Found:
    objects = heard.objects.get(node, {})

    def value(thing: _Object) -> int | None:
        return next((answer for answer in objects.get(thing, ()) if answer is not None), None)

    device_type = value(_DEVICE_TYPE)
    profile = None if device_type is None else device_type & 0xFFFF
    serials = {answer for answer in objects.get(_SERIAL, ()) if answer is not None}
    state = describe_state(heard.states[node]) if node in heard.states else "no heartbeat"
    return Found(
        node,
        "" if device_type is None else f"CiA {profile} (0x{device_type:08X})",
        profile,
        value(_VENDOR),
        value(_PRODUCT),
        tuple(sorted(serials)),
        state,
        max((len(answers) for answers in objects.values()), default=0),
    )
