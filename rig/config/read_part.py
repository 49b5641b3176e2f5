"""What can be read of a profile that is not valid: more may be wrong with it."""

from collections.abc import Sequence
from typing import NamedTuple

from rig.config.diagnostics import Diagnostic, ProfileError
from rig.config.models import Profile


class ReadPart(NamedTuple):
    """The part of a profile that could be read though it is not valid.

    Parameters
    ----------
    profile : Profile
        Without the devices, buses and laws that cannot be read; settings that cannot are None.
    lacking : tuple of str
        The devices that it would have.
    is_made : bool
        Cycle, mechanism and buses could be read: its devices can be held against them.
    """

    profile: Profile
    lacking: tuple[str, ...]
    is_made: bool


class PartlyRead(ProfileError):
    """A profile is not valid; a part of it could be read.

    Parameters
    ----------
    diagnostics : sequence of Diagnostic
        The errors.
    part : ReadPart
        What could be read.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic], part: ReadPart) -> None:
        super().__init__(diagnostics)
        self.part = part
