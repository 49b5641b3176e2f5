"""What may happen to chosen frames on an emulated bus, either way."""

from dataclasses import dataclass
from functools import partial
from typing import Literal

from drivers.sim.nodes.bus_node import BusNode

Kind = Literal["drop", "delay", "duplicate", "truncate", "corrupt"]
_KINDS: tuple[Kind, ...] = ("drop", "delay", "duplicate", "truncate", "corrupt")


@dataclass(frozen=True, slots=True)
class FrameFault:
    """Something that happens to some frames of one CAN id.

    Parameters
    ----------
    kind : str
        ``"drop"``: they are lost; ``"delay"``: they come `value` seconds later;
        ``"duplicate"``: they come twice; ``"truncate"``: only `value` bytes come;
        ``"corrupt"``: byte `value` is inverted.
    can_id : int
        Of the frames.
    count : int
        How many frames.
    after : int
        How many frames pass first.
    value : float
        What the kind says.
    """

    kind: Kind
    can_id: int
    count: int = 1
    after: int = 0
    value: float = 0.0


class FrameFaults:
    """The frame faults of one bus; costs one dictionary look-up where there are none."""

    def __init__(self) -> None:
        # By CAN id: each fault with the number of frames seen so far.
        self._faults: dict[int, list[tuple[FrameFault, list[int]]]] = {}

    def add(self, fault: FrameFault) -> None:
        """Have it happen to the next frames; several on one id act one after the other."""
        self._faults.setdefault(fault.can_id, []).append((fault, [0]))

    def clear(self) -> None:
        """Let all frames pass again."""
        self._faults.clear()

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

    def apply(self, can_id: int, data: bytes) -> list[tuple[float, bytes]]:
        """Return what becomes of a frame: a delay (s) and the data of each that arrives."""
        if not self._faults or can_id not in self._faults:
            return [(0.0, data)]
        frames = [(0.0, data)]
        for fault, seen in self._faults[can_id]:
            seen[0] += 1
            if fault.after < seen[0] <= fault.after + fault.count:
                frames = [item for frame in frames for item in _happen(fault, *frame)]
        self._faults[can_id] = [
            (fault, seen)
            for fault, seen in self._faults[can_id]
            if seen[0] < fault.after + fault.count
        ]
        if not self._faults[can_id]:
            del self._faults[can_id]
        return frames


def _happen(fault: FrameFault, delay: float, data: bytes) -> list[tuple[float, bytes]]:
    match fault.kind:
        case "drop":
            return []
        case "delay":
            return [(delay + fault.value, data)]
        case "duplicate":
            return [(delay, data), (delay, data)]
        case "truncate":
            return [(delay, data[: int(fault.value)])]
        case "corrupt":
            changed = bytearray(data)
            if changed:
                changed[int(fault.value) % len(changed)] ^= 0xFF
            return [(delay, bytes(changed))]
