"""The identifier flags of SocketCAN."""

from typing import Final

EXTENDED_FLAG: Final = 0x8000_0000
REMOTE_FLAG: Final = 0x4000_0000
ERROR_FLAG: Final = 0x2000_0000
STANDARD_MASK: Final = 0x0000_07FF
EXTENDED_MASK: Final = 0x1FFF_FFFF
