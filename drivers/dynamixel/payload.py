"""One register of several servos, packed for a sync write."""

import struct
from collections.abc import Iterable, Sequence

from drivers.dynamixel.codec import encode_sync_write
from drivers.dynamixel.registers import Register


class SyncPayload:
    """Packs one value per servo, each after its id.

    Parameters
    ----------
    register : Register
        What is written.
    ids : sequence of int
        Of the servos, in the order of the values.
    """

    __slots__ = ("_ids", "_pack", "register")

    def __init__(self, register: Register, ids: Sequence[int]) -> None:
        self.register = register
        self._ids = tuple(ids)
        self._pack = struct.Struct("<" + f"B{register.code}" * len(self._ids)).pack

    def pack(self, values: Iterable[int]) -> bytes:
        """Return what stands behind the register's address and size in the packet."""
        flat: list[int] = []
        for servo, value in zip(self._ids, values, strict=True):
            flat += (servo, value)
        return self._pack(*flat)

    def same(self, value: int) -> bytes:
        """Return the same value for every servo."""
        return self.pack((value,) * len(self._ids))

    def packet(self, value: int) -> bytes:
        """Return the whole packet with the same value for every servo."""
        register = self.register
        return encode_sync_write(register.address, register.size, self.same(value))
