"""What bit rate an interface was really set to, where the kernel tells.

References
----------
iproute2, ip-link(8): ``ip -details -json link show``; virtual interfaces and serial adapters have
no ``bittiming`` there.
"""

import json
import subprocess
from typing import Final

_PATIENCE: Final = 2.0  # for ip to answer, s


def bitrate_of(channel: str) -> int | None:
    """Return the bit rate of a SocketCAN interface, bit/s, or None where nobody tells it."""
    try:
        told = subprocess.run(
            ["ip", "-details", "-json", "link", "show", "dev", channel],
            capture_output=True,
            timeout=_PATIENCE,
            check=True,
        ).stdout
        (link,) = json.loads(told)
        return int(link["linkinfo"]["info_data"]["bittiming"]["bitrate"])
    except (OSError, subprocess.SubprocessError, ValueError, KeyError, TypeError):
        return None
