"""PDO parameters of an emulated node and the rules under which a master may change them.

The rules are those of CANopenNode, stricter than CiA 301 leaves a device free to be:
a COB-ID changes only by way of "not valid" (bit 31), a mapping only while the PDO is not
valid and its count is 0, and every entry is checked when it is written.

References
----------
CiA 301 V4.2, section 7.2.2 (PDO) and objects 0x1400, 0x1600, 0x1800, 0x1A00.
"""

from collections.abc import Sequence
from math import inf
from struct import Struct
from typing import ClassVar, Protocol

from drivers.sim.nodes.object_dictionary import (
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    Abort,
    ObjectDictionary,
    SdoAbortError,
    Variable,
)

MAX_ENTRIES = 8
NOT_VALID = 1 << 31
NO_RTR = 1 << 30
LAST_SYNCHRONOUS, _FIRST_EVENT_DRIVEN = 240, 254
"""Transmission types."""

# Identifiers that CiA 301 table 24 reserves for other services.
_RESTRICTED = (
    range(0x080),
    range(0x101, 0x181),
    range(0x581, 0x600),
    range(0x601, 0x680),
    range(0x6E0, 0x700),
    range(0x701, 0x800),
)

# Dummy entries (CiA 301 section 7.4.7): index = number of a data type, value = its bytes.
_DUMMY_BYTES = {0x0002: 1, 0x0003: 2, 0x0004: 4, 0x0005: 1, 0x0006: 2, 0x0007: 4}


class PdoHost(Protocol):
    """The node, as each of its PDOs needs it."""

    dictionary: ObjectDictionary
    """Gets the PDO's parameters and holds what is mapped."""

    def route(self) -> None:
        """Route anew: validity or COB-ID of a PDO have changed."""

    def transmit(self, can_id: int, data: bytes) -> None:
        """Send a frame."""


class Pdo:
    """Base of receive and transmit PDOs: COB-ID, type and mapping.

    Parameters
    ----------
    host : PdoHost
        The node.
    number : int
        Of the PDO, from 0.
    cob_id : int
        Default COB-ID with the bits 30 and 31.
    entries : sequence of int
        Default mapping.
    """

    direction: ClassVar[str]
    """``"r"`` or ``"t"``: which objects may be mapped."""

    records: ClassVar[tuple[int, int]]
    """Indices of the first PDO's communication and mapping parameters."""

    def __init__(self, host: PdoHost, number: int, cob_id: int, entries: Sequence[int]) -> None:
        self.number = number
        self._host = host
        self._dictionary = host.dictionary
        add = self._dictionary.add
        communication, mapping = (record + number for record in self.records)
        add(communication, 0, Variable(UNSIGNED8, 5, "const"))
        self._cob_id = add(
            communication,
            1,
            Variable(UNSIGNED32, cob_id, check=self._check_cob_id, changed=self.configure),
        )
        self._type = add(
            communication,
            2,
            Variable(UNSIGNED8, 255, check=self._check_type, changed=self.configure),
        )
        self._count = add(
            mapping,
            0,
            Variable(UNSIGNED8, len(entries), check=self._check_count, changed=self.configure),
        )
        padded = [*entries, *[0] * (MAX_ENTRIES - len(entries))]
        self._entries = [
            add(mapping, sub, Variable(UNSIGNED32, entry, check=self._check_entry))
            for sub, entry in enumerate(padded, start=1)
        ]
        self.can_id: int | None = None
        self.transmission_type = 255
        self.variables: tuple[Variable, ...] = ()
        self.layout = Struct("<")

    def configure(self) -> None:
        """Precompile the PDO from its parameters as they are now."""
        cob_id = self._cob_id.integer
        self.can_id = None if cob_id & NOT_VALID else cob_id & 0x7FF
        self.transmission_type = self._type.integer
        code = "<"
        variables = []
        for entry in self._entries[: self._count.integer]:
            index, sub, bits = _split(entry.integer)
            if index in _DUMMY_BYTES:
                code += f"{bits // 8}x"
            else:
                variable = self._dictionary.find(index, sub)
                code += variable.data_type.code
                variables.append(variable)
        self.variables = tuple(variables)
        self.layout = Struct(code)
        self._host.route()

    def _check_cob_id(self, value: int) -> None:
        can_id = value & 0x7FF
        if value & 0x3FFFF800:  # bit 29: extended identifiers are not offered
            raise SdoAbortError(Abort.RANGE)
        if value & NOT_VALID:
            return
        moved = self.can_id is not None and can_id != self.can_id
        if moved or not self._count.value or any(can_id in ids for ids in _RESTRICTED):
            raise SdoAbortError(Abort.RANGE)

    def _check_type(self, value: int) -> None:
        # Between them: reserved, and on remote request, which is not offered.
        if LAST_SYNCHRONOUS < value < _FIRST_EVENT_DRIVEN:
            raise SdoAbortError(Abort.RANGE)

    def _check_entry(self, value: int) -> None:
        if self.can_id is not None or self._count.value:
            raise SdoAbortError(Abort.UNSUPPORTED_ACCESS)
        if value:
            self._mapped_bits(value)

    def _check_count(self, value: int) -> None:
        if self.can_id is not None:
            raise SdoAbortError(Abort.UNSUPPORTED_ACCESS)
        if value > MAX_ENTRIES:
            raise SdoAbortError(Abort.MAPPING_TOO_LONG)
        if sum(self._mapped_bits(entry.integer) for entry in self._entries[:value]) > 64:
            raise SdoAbortError(Abort.MAPPING_TOO_LONG)

    def _mapped_bits(self, entry: int) -> int:
        """Return the length of a mapping entry in bits, or refuse it."""
        index, sub, bits = _split(entry)
        if index in _DUMMY_BYTES:
            if self.direction == "r" and sub == 0 and bits == 8 * _DUMMY_BYTES[index]:
                return bits
            raise SdoAbortError(Abort.NOT_MAPPABLE)
        variable = self._dictionary.find(index, sub)
        if self.direction not in variable.mapping or bits != 8 * variable.data_type.size:
            raise SdoAbortError(Abort.NOT_MAPPABLE)
        return bits


class ReceivePdo(Pdo):
    """A PDO that the node consumes, with deadline monitoring (sub-index 5)."""

    direction = "r"
    records = (0x1400, 0x1600)

    def __init__(self, host: PdoHost, number: int, cob_id: int, entries: Sequence[int]) -> None:
        super().__init__(host, number, cob_id, entries)
        self._timer = host.dictionary.add(
            self.records[0] + number, 5, Variable(UNSIGNED16, 0, changed=self.stop_watching)
        )
        self.due = inf
        self.waiting: bytes | None = None
        """What was received and acts only at the next SYNC."""

    def stop_watching(self) -> None:
        """Expect nothing until the next frame came; drop what waits for SYNC."""
        self.due = inf
        self.waiting = None

    def receive(self, data: bytes, now: float) -> bool:
        """Take a frame of sufficient length; return whether objects changed at once."""
        if self._timer.value:
            self.due = now + self._timer.integer * 1e-3
        if self.transmission_type <= LAST_SYNCHRONOUS:
            self.waiting = data
            return False
        self._apply(data)
        return True

    def synchronise(self) -> None:
        """Apply what waits for SYNC."""
        if self.waiting is not None:
            self._apply(self.waiting)
            self.waiting = None

    def _apply(self, data: bytes) -> None:
        values: tuple[float, ...] = self.layout.unpack_from(data)  # strings are not mappable
        for variable, value in zip(self.variables, values):  # noqa: B905 - takes half as long
            # A PDO has no way to refuse; a value out of range leaves the object as it was.
            if variable.low <= value <= variable.high:
                variable.value = value


class TransmitPdo(Pdo):
    """A PDO that the node produces: on SYNC, on change, by event timer, not too often."""

    direction = "t"
    records = (0x1800, 0x1A00)

    def __init__(self, host: PdoHost, number: int, cob_id: int, entries: Sequence[int]) -> None:
        super().__init__(host, number, cob_id, entries)
        communication = self.records[0] + number
        self._inhibit = host.dictionary.add(
            communication, 3, Variable(UNSIGNED16, 0, check=self._check_inhibit)
        )
        self.event_timer = host.dictionary.add(
            communication, 5, Variable(UNSIGNED16, 0, changed=self.restart)
        )
        self._syncs = 0
        self._changed = False
        self._next_event = inf
        self._not_before = -inf

    @property
    def event_driven(self) -> bool:
        """Whether it is sent on change and by the event timer."""
        return self.transmission_type >= _FIRST_EVENT_DRIVEN

    @property
    def due(self) -> float:
        """When it wants to be sent without a SYNC, s."""
        if self.can_id is None or not self.event_driven:
            return inf
        return self._not_before if self._changed else max(self._next_event, self._not_before)

    def restart(self) -> None:
        """Begin anew: an event-driven PDO is sent once when the node starts."""
        self._syncs = 0
        self._changed = True
        self._next_event = inf
        self._not_before = -inf
        self._host.route()

    def note_change(self) -> None:
        """Remember that a mapped object changed."""
        self._changed = True

    def wants_sync(self) -> bool:
        """Count a SYNC and return whether this one asks for the PDO."""
        if self.can_id is None or self.transmission_type > LAST_SYNCHRONOUS:
            return False
        if self.transmission_type == 0:
            return self._changed
        self._syncs += 1
        return self._syncs >= self.transmission_type

    def transmit(self, now: float) -> None:
        """Pack the mapped objects and send them."""
        self._syncs = 0
        self._changed = False
        if self.transmission_type >= _FIRST_EVENT_DRIVEN:
            timer = self.event_timer.integer
            self._next_event = now + timer * 1e-3 if timer else inf
            self._not_before = now + self._inhibit.integer * 1e-4
        if self.can_id is not None:
            self._host.transmit(
                self.can_id, self.layout.pack(*[item.value for item in self.variables])
            )

    def _check_inhibit(self, _: int) -> None:
        if self.can_id is not None:
            raise SdoAbortError(Abort.RANGE)


def _split(entry: int) -> tuple[int, int, int]:
    """Return index, sub-index and length in bits of a mapping entry."""
    return entry >> 16, entry >> 8 & 0xFF, entry & 0xFF
