"""What a law that shakes its setpoints costs: the life of the regulators' valves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rig.config import Profile

_DITHERS: Final = (("dither", "amplitude", 12.5e3), ("path_dither", "force", 0.0))
"""Sections of laws, what each shakes by, and from which on a setpoint turns round by 25 kPa."""
_CYCLES: Final = 10e6
"""Of a valve, for an example: a catalogue says its own."""


def valve_life_remarks(profile: Profile) -> Iterator[str]:
    """Yield which laws of a profile shake valves so that their life is counted in hours.

    Parameters
    ----------
    profile : Profile
        Checked.
    """
    from rig.assembly.same_geometry import number_at

    for law, settings in profile.controllers.items():
        for section, size, least in _DITHERS:
            by = number_at(settings, f"{section}.{size}")
            frequency = number_at(settings, f"{section}.frequency")
            if by is None or frequency is None or by <= least:
                continue
            hours = _CYCLES / frequency / 3600.0
            yield (
                f"controllers.{law}.{section} shakes the setpoints at {frequency:.3g} Hz while the "
                f"rig is slow: for that alone each valve turns round {2.0 * frequency:.3g} times a "
                f"second, and {_CYCLES / 1e6:g} million cycles, if that is its life, are "
                f"{hours:.2g} h; ask the regulators' maker before it runs for hours (rig explain "
                "valve_reversals)"
            )
