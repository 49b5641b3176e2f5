"""What a profile says of its cylinders, and its simulated plant says otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rig.config import Profile

_MOST: Final = 0.1
"""Share by which the two may differ: drawings are not better, and units differ by as much."""
_MOST_FRICTION: Final = 1.5
"""Times by which frictions may differ, either way: units differ by 1.15, and by 0.6 to 1.6 what
nobody has measured."""


def plant_remarks(profile: Profile) -> Iterator[str]:
    """Yield in what the simulated rig is another one than the profile tells the controllers of.

    Parameters
    ----------
    profile : Profile
        Checked. Bore, rod, stroke and home that differ are refused; these here only mislead.
    """
    from rig.assembly.build import make_unconnected
    from rig.assembly.same_geometry import number_at
    from rig.hal.formats import format_quantity

    if profile.plant is None:
        return
    plant, name = profile.plant.settings, profile.mechanism
    mechanism, _ = make_unconnected(profile)
    carriage, piston = (number_at(plant, key) for key in ("carriage.mass", "cylinder.mass"))
    yield from _friction_remark(profile, plant)
    pairs: list[tuple[str, float | None, str, float | None, str, str]] = [
        (
            "the range of its regulators",
            number_at(getattr(mechanism, "settings", None), "regulator_response.full_scale"),
            "plant.regulator.full_scale",
            number_at(plant, "regulator.full_scale"),
            "Pa",
            "their errors, steps and hysteresis are simulated as shares of that",
        ),
        (
            f"{name}.moving_mass",
            number_at(profile.mechanism_settings, "moving_mass"),
            f"plant.carriage.mass{_shown(carriage)} and twice plant.cylinder.mass{_shown(piston)} "
            "together",
            None if carriage is None or piston is None else carriage + 2.0 * piston,
            "kg",
            "gains that are tuned on it fit another rig",
        ),
    ]
    for ours, believed, theirs, true, unit, so in pairs:
        if believed is None or true is None or abs(believed - true) <= _MOST * believed:
            continue
        yield (
            f"{ours} is {format_quantity(believed, unit)}, and {theirs} is "
            f"{format_quantity(true, unit)}: {so}; say both alike"
        )


def _friction_remark(profile: Profile, plant: object) -> Iterator[str]:
    """Yield that the simulated seals take another force than the laws are told, if they do."""
    from rig.assembly.same_geometry import number_at
    from rig.hal.formats import format_quantity

    told = profile.mechanism_settings
    believed, pressure = (number_at(told, key) for key in ("friction.coulomb", "base_pressure"))
    area, simulated = getattr(told, "area", None), getattr(plant, "coulomb_friction", None)
    scale = number_at(plant, "friction_scale")
    if not believed or pressure is None or area is None or simulated is None or not scale:
        return
    true = simulated(pressure, area)
    if max(true / believed, believed / true) <= _MOST_FRICTION:
        return
    yield (
        f"{profile.mechanism}.friction.coulomb is {format_quantity(believed, 'N')}, and that of a "
        f"simulated pair {format_quantity(true, 'N')} (plant.friction_scale {scale:.3g}): what "
        "runs well in simulation may stick or swing on the rig; plant.friction_scale: "
        f"{scale * believed / true:.3g} makes them alike"
    )


def _shown(mass: float | None) -> str:
    """Return a mass in brackets, behind the key that says it."""
    from rig.hal.formats import format_quantity

    return "" if mass is None else f" ({format_quantity(mass, 'kg')})"
