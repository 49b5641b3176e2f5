"""What gains of a pneumatic mechanism on valves have to bear."""

from typing import Final

from rig.hal.bench import Unknown
from rig.mechanisms.pneumatic.unknowns import JOINT_UNKNOWNS, UNKNOWNS

_SPOOL: Final = (
    # Nothing measures these: a data sheet says them within a factor. E.
    Unknown(
        "spool", ("spool_bandwidth",), "",
        guessed=(0.67, 1.5), measured=(0.67, 1.5), measured_by="valves",
    ),
    Unknown(
        "dead time", ("spool_dead_time",), "s",
        guessed=(-1e-3, 1e-3), measured=(-1e-3, 1e-3), measured_by="valves",
    ),
)  # fmt: skip
VALVE_UNKNOWNS: Final = (UNKNOWNS[0], *_SPOOL)
JOINT_VALVE_UNKNOWNS: Final = (JOINT_UNKNOWNS[0], *_SPOOL)
"""Friction and spools, each with its bounds; see `rig.mechanisms.pneumatic.unknowns`."""
