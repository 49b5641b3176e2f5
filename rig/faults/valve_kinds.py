"""What may break of proportional valves; their chambers and wires are in `world_kinds`."""

from rig.faults.kind import Magnitudes, either, safe
from rig.faults.world_kinds import ALONE, of_device, of_plant, until_moved

_MADE_UP = "the inner loop makes up for what is small, and a pressure may rest"
_STANDS = "where it shuts its chamber is a spring, and holds until something is to move"

KINDS = (
    until_moved(of_plant("valve_stuck", "A spool stands still.", forgives=ALONE, why=_STANDS)),
    of_device("valve_stuck_at", "A spool goes to some opening and stays there.", either, 1.0,
              fault="valve_stuck", forgives=ALONE,
              magnitude=Magnitudes(0.01, 1.0, "1", signed=True),
              why="near its middle nothing is amiss; beyond, its chamber fills or empties, and "
              "once the supply is shut it empties either way"),
    of_plant("valve_open", "A spool goes to its feed.", safe, 0.2, forgives=ALONE),
    until_moved(
        of_plant("valve_closed", "A spool goes to its middle.", forgives=ALONE, why=_STANDS)
    ),
    of_device("valve_slow", "A spool takes so many times as long.", either, 2.0,
              magnitude=Magnitudes(1.2, 6.0, "1"), why=_MADE_UP),
    of_device("valve_offset", "The middle of a spool is off.", either, 1.0,
              magnitude=Magnitudes(2e-3, 0.1, "1", signed=True), why=_MADE_UP),
    of_device("valve_leak", "A spool leaks from the supply where it is shut.", either, 1.0,
              magnitude=Magnitudes(1e-12, 1e-9, "m^3/(s Pa)"), why=_MADE_UP),
)  # fmt: skip
