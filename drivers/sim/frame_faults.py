"""What may happen to chosen frames on an emulated bus, either way."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple

from drivers.sim.nodes.bus_node import BusNode

Kind = Literal["drop", "delay", "duplicate", "truncate", "corrupt", "reorder", "spoof"]
_KINDS: tuple[Kind, ...] = ("drop", "delay", "duplicate", "truncate", "corrupt")
"""Those that are offered by name in a schedule, for the next frame."""
_ALL: tuple[Kind, ...] = (*_KINDS, "reorder", "spoof")
LASTING = 1 << 60
"""So many frames are all of them."""


def kind_of(name: str) -> Kind:
    """Return the kind of that name.

    Raises
    ------
    ValueError
        There is none.
    """
    for kind in _ALL:
        if kind == name:
            return kind
    raise ValueError(f"frames: no fault {name!r}; known are {', '.join(_ALL)}")


@dataclass(frozen=True, slots=True)
class FrameFault:
    """Something that happens to some frames of one CAN id.

    Parameters
    ----------
    kind : str
        ``"drop"``: they are lost; ``"delay"``: they come `value` seconds later;
        ``"duplicate"``: they come twice; ``"truncate"``: only `value` bytes come, and one at
        least is missing; ``"corrupt"``: byte `value` is inverted; ``"reorder"``: every other one
        comes `value` seconds later, after its successor; ``"spoof"``: somebody sends the same
        identifier with inverted data right after it.
    can_id : int
        Of the frames.
    count : int
        How many frames.
    after : int
        How many frames pass first.
    value : float
        What the kind says.
    changed : callable, optional
        Called for each frame that says something else than the one before it.
    """

    kind: Kind
    can_id: int
    count: int = 1
    after: int = 0
    value: float = 0.0
    changed: Callable[[], None] | None = None


class Arrival(NamedTuple):
    """A frame that comes of one that was sent.

    Parameters
    ----------
    delay : float
        Until it arrives, s.
    data : bytes
        What arrives.
    is_foreign : bool
        Whether somebody else sent it, so that whoever sent the first one hears it, too.
    """

    delay: float
    data: bytes
    is_foreign: bool = False


class FrameFaults:
    """The frame faults of one bus."""

    def __init__(self) -> None:
        self.by_id: dict[int, list[tuple[FrameFault, list[int]]]] = {}
        """Each fault with the number of frames seen so far; empty: all frames pass."""
        self._last: dict[int, bytes] = {}

    def add(self, fault: FrameFault) -> None:
        """Have it happen to the next frames; several on one id act one after the other."""
        self.by_id.setdefault(fault.can_id, []).append((fault, [0]))

    def remove(self, fault: FrameFault) -> None:
        """End one fault; nothing happens if it has ended."""
        left = [entry for entry in self.by_id.pop(fault.can_id, ()) if entry[0] is not fault]
        if left:
            self.by_id[fault.can_id] = left
        else:
            self._last.pop(fault.can_id, None)

    def clear(self) -> None:
        """Let all frames pass again."""
        self.by_id.clear()

    def offer(self, node: BusNode) -> None:
        """Make the faults of a node's frames known to it by name.

        ``drop_frames`` (value: how many, default 1), ``delay_frames`` (value: s, default
        5 ms), ``duplicate_frames``, ``truncate_frames`` (value: bytes left, default 3) and
        ``corrupt_frames`` (value: which byte, default 0) act on the next frame, or frames,
        of every transmit PDO that the node has enabled; a repair ends them.
        """
        for kind in _KINDS:
            node.add_fault(f"{kind}_frames", partial(self._inject, node, kind), self.clear)

    def _inject(self, node: BusNode, kind: Kind, value: float | None) -> None:
        if value is not None and (value < 0.0 or (kind != "delay" and value != int(value))):
            raise ValueError(f"{node.name}: {kind}_frames does not take {value:g}")
        count = int(value) if kind == "drop" and value is not None else 1
        setting = {"delay": 5e-3, "truncate": 3.0}.get(kind, 0.0) if value is None else value
        for can_id in node.transmit_ids:
            self.add(FrameFault(kind, can_id, count=count, value=setting))

    def apply(self, can_id: int, data: bytes) -> list[Arrival]:
        """Return what becomes of a frame: each that arrives."""
        if can_id not in self.by_id:
            return [Arrival(0.0, data)]
        frames = [Arrival(0.0, data)]
        is_new = data != self._last.get(can_id, data)
        self._last[can_id] = data
        for fault, seen in self.by_id[can_id]:
            seen[0] += 1
            if is_new and fault.changed is not None:
                fault.changed()
            if fault.after < seen[0] <= fault.after + fault.count:
                odd = bool(seen[0] % 2)
                frames = [item for frame in frames for item in _happen(fault, frame, odd)]
        self.by_id[can_id] = [
            (fault, seen)
            for fault, seen in self.by_id[can_id]
            if seen[0] < fault.after + fault.count
        ]
        if not self.by_id[can_id]:
            del self.by_id[can_id]
        return frames


def _happen(fault: FrameFault, frame: Arrival, odd: bool) -> list[Arrival]:
    delay, data, _ = frame
    match fault.kind:
        case "drop":
            return []
        case "delay":
            return [frame._replace(delay=delay + fault.value)]
        case "duplicate":
            return [frame, frame]
        case "truncate":
            return [frame._replace(data=data[: min(int(fault.value), max(len(data) - 1, 0))])]
        case "corrupt":
            changed = bytearray(data)
            if changed:
                changed[int(fault.value) % len(changed)] ^= 0xFF
            return [frame._replace(data=bytes(changed))]
        case "reorder":
            return [frame._replace(delay=delay + (fault.value if odd else 0.0))]
        case "spoof":
            return [frame, Arrival(delay, bytes(byte ^ 0xFF for byte in data), is_foreign=True)]
