"""Where a step happens: the rig, whoever stands at it, and what is known of it so far."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, cast

from rig.assembly import Rig
from rig.commissioning.operator import Operator
from rig.config import Profile
from rig.hal.world import BreakableWorld

SOON = 0.5
"""How long a simulated hand is waited for, s."""
PATIENCE = 60.0
"""How long a person is waited for, s."""

GLANCE = 15.0
"""How long a person may take to read a gauge that does not stay, s."""


class Site(NamedTuple):
    """The place of a step.

    Parameters
    ----------
    profile : Profile
        The rig's.
    make_rig : callable
        Builds the rig of a profile, which may be gentler than the site's; nothing is opened yet.
    operator : Operator
        Who stands at it.
    out : Path
        Where run folders live.
    on : str or None
        Other interfaces than the profile's.
    hands : BreakableWorld or None
        The simulated world of another process, which hands reach (`rig simulate`).
    """

    profile: Profile
    make_rig: Callable[[Profile], Rig]
    operator: Operator
    out: Path
    on: str | None = None
    hands: BreakableWorld | None = None

    def world_of(self, rig: Rig) -> BreakableWorld | None:
        """Return the simulated world of a rig that hands reach; None: it is a real one."""
        if not rig.backend.is_simulated:
            return self.hands
        return cast("BreakableWorld", rig.clock.world)  # type: ignore[attr-defined]

    def patience(self, rig: Rig) -> float:
        """Return how long somebody is waited for, s."""
        return PATIENCE if self.world_of(rig) is None else SOON

    def glance(self, rig: Rig) -> float:
        """Return how long something is kept for somebody to read it, s."""
        return GLANCE if self.world_of(rig) is None else 0.0
