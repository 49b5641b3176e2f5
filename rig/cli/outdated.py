"""What was calibrated before a profile was changed in what it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rig.config.basis import changes_of

if TYPE_CHECKING:
    from rig.calibration.procedure import AnyProcedure
    from rig.config import Profile


def changes_since(
    name: str, procedure: AnyProcedure, profile: Profile, entries: Sequence[dict[str, object]]
) -> dict[str, tuple[str, ...]]:
    """Return what of a profile was changed since a procedure, or one like it, was done.

    Parameters
    ----------
    name : str
        The procedure's.
    procedure : Procedure
        What was done.
    profile : Profile
        As it is now.
    entries : sequence of dict
        What it has found, or another one that finds the same.
    """
    done = {str(entry["procedure"]) for entry in entries}
    of = {name} if name in done else done
    in_force = [profile.calibrations.get(target) for target in procedure.targets(profile)]
    found: dict[str, tuple[str, ...]] = {}
    for calibration in filter(None, in_force):
        for by, changes in changes_of(calibration, profile).items():
            if by in of:
                found[by] = (*found.get(by, ()), *changes)
    return found


def procedures_outdated(profile: Profile) -> list[str]:
    """Return the procedures that were done before their profile was changed, in their order."""
    from rig.calibration.catalogue import procedures

    changed = {by for its in profile.calibrations.values() for by in changes_of(its, profile)}
    return [name for name in procedures(profile) if name in changed]
