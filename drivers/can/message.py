"""The frame that is given to python-can's interfaces; imported only where one is open."""

from typing import Any

import can


class Message(can.Message):
    """A frame that is cheap to copy.

    python-can's ``virtual`` interface copies a frame for every receiver, attribute by attribute:
    a quarter of a run in virtual time. Only the data needs it, everything else is immutable.
    """

    __slots__ = ()

    def __deepcopy__(self, memo: dict[int, Any] | None) -> "Message":
        return Message(
            self.timestamp,
            self.arbitration_id,
            self.is_extended_id,
            self.is_remote_frame,
            self.is_error_frame,
            data=bytearray(self.data),
            dlc=self.dlc,
        )
