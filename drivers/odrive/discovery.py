"""Ask a CANSimple bus who is there, without changing anything on it.

References
----------
ODrive Robotics, "CAN Protocol" of firmware 0.6: Address, Get_Version, Heartbeat.
"""

from collections import defaultdict
from collections.abc import Collection
from typing import Final

from drivers.can.frame import REMOTE_FLAG, STANDARD_MASK
from drivers.odrive.codec import (
    Command,
    can_id,
    decode_address,
    decode_heartbeat,
    decode_version,
    describe_axis_state,
)
from rig.hal import Clock, FastCanBus
from rig.hal.frames import Found

_EVERYBODY: Final = 0x3F
_PAUSE: Final = 2e-3  # s
_COMMANDS: Final = 0x1F


def survey_odrives(
    bus: FastCanBus, clock: Clock, expected: Collection[int] = (), *, listen: float = 1.0
) -> list[Found]:
    """Return who answers on an open bus, by node number; see `survey_canopen`."""
    del expected  # an axis answers in every state
    heard: dict[int, dict[int, list[bytes]]] = defaultdict(lambda: defaultdict(list))
    send = bus.send_data

    def hear(until: float) -> None:
        while True:
            for flagged, data in bus.drain(256):
                if flagged <= STANDARD_MASK:
                    heard[flagged >> 5][flagged & _COMMANDS].append(data)
            now = clock.now()
            if now >= until:
                return
            clock.sleep_until(min(now + _PAUSE, until))

    until = clock.now() + listen
    send(can_id(_EVERYBODY, Command.ADDRESS) | REMOTE_FLAG, b"")
    hear(clock.now() + 0.5 * listen)
    for node in [node for node in heard if node != _EVERYBODY]:
        send(can_id(node, Command.GET_VERSION) | REMOTE_FLAG, b"")
        hear(clock.now() + _PAUSE)
    hear(until)
    return [_describe(node, frames) for node, frames in sorted(heard.items()) if node != _EVERYBODY]


def _describe(node: int, frames: dict[int, list[bytes]]) -> Found:
    addresses = [data for data in frames.get(Command.ADDRESS, ()) if len(data) >= 7]
    versions = [data for data in frames.get(Command.GET_VERSION, ()) if len(data) == 8]
    beats = [data for data in frames.get(Command.HEARTBEAT, ()) if len(data) >= 7]
    kind = ""
    if versions:
        kind = "ODrive " + ".".join(map(str, decode_version(versions[0]).firmware))
    state = "no heartbeat"
    if beats:
        beat = decode_heartbeat(beats[-1])
        state = describe_axis_state(beat.state)
        if beat.errors:
            state += f", errors 0x{beat.errors:08X}"
    return Found(
        node,
        kind,
        serials=tuple(sorted({decode_address(data)[1] for data in addresses})),
        state=state,
        answers=max(len(addresses), len(versions)),
    )
