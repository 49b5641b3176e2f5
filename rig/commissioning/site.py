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


class Site(NamedTuple):
    """The place of a step.

    Parameters
    ----------
    profile : Profile
        The rig's.
    make_rig : callable
        Builds the rig; nothing is opened yet.
    operator : Operator
        Who stands at it.
    out : Path
        Where run folders live.
    on : str or None
        Other interfaces than the profile's.
    """

    profile: Profile
    make_rig: Callable[[], Rig]
    operator: Operator
    out: Path
    on: str | None = None


def world_of(rig: Rig) -> BreakableWorld | None:
    """Return the simulated world of a rig; None: it is a real one, or in another process."""
    if not rig.backend.is_simulated:
        return None
    return cast("BreakableWorld", rig.clock.world)  # type: ignore[attr-defined]


def patience(rig: Rig) -> float:
    """Return how long somebody is waited for, s."""
    return SOON if rig.backend.is_simulated else PATIENCE
