"""What a rig has from a profile whose dimensions are not its own: nobody measured it there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rig.cli.inherited_limits import SIZES, limits_that_rest_on
from rig.cli.names import TUNED_LAW

if TYPE_CHECKING:
    from rig.config import Profile

_GAINS = "controllers"


def inherited_sentences(profile: Profile, search: Sequence[Path]) -> list[str]:
    """Say what a rig has from files in which a dimension is another, and what comes next.

    Parameters
    ----------
    profile : Profile
        Valid.
    search : sequence of Path
        The folders of configurations.
    """
    from rig.assembly import REGISTRY

    varies_with = REGISTRY.load("mechanism", profile.mechanism).varies_with
    sentences = []
    for base in _bases(profile) if varies_with else ():
        others = dict(_other_dimensions(profile, base, search, varies_with))
        affected = dict.fromkeys(key for dimension in others for key in varies_with[dimension])
        keys = [key for name in affected for key in _keys_in(name, base, profile)]
        laws = [
            law
            for law in profile.controllers
            if law not in profile.tunings and _stands_in(f"{_GAINS}.{law}.", base, profile)
        ]
        if others and (keys or laws):
            sentences.append(_sentence(profile, base, list(others.values()), keys, laws))
        sentences.extend(_of_limits(profile, base, search))
    return sentences


def _of_limits(profile: Profile, base: Path, search: Sequence[Path]) -> Iterator[str]:
    """Yield that limits are those of other cylinders, and what they come to here."""
    known = [size for size in SIZES if hasattr(profile.mechanism_settings, size)]
    others = dict(_other_dimensions(profile, base, search, known))
    meant = {
        key: told
        for key, told in limits_that_rest_on(profile.mechanism_settings, set(others))
        if _stands_in(f"{profile.mechanism}.{key}", base, profile)
    }
    if meant:
        yield (
            f"{', '.join(meant)}: from {base}, where {', '.join(others.values())}: "
            f"{'; '.join(meant.values())}. No calibration finds that: "
            f"say in {profile.files[0]} what is meant"
        )


def _sentence(
    profile: Profile, base: Path, dimensions: list[str], keys: list[str], laws: list[str]
) -> str:
    gains = [f"the gains of {', '.join(laws)}"] if laws else []
    told = (
        f"{' and '.join([', '.join(keys), *gains] if keys else gains)}: from {base}, where "
        f"{' and '.join(dimensions)}; nobody has measured or tuned them on {profile.name}"
    )
    steps = []
    if keys and profile.calibration is None:
        steps.append(f"rig calibrate {profile.argument} --all")
    if laws:
        which = "" if TUNED_LAW in laws else f" --controller {laws[0]}"
        steps.append(f"rig tune {profile.argument}{which}")
    if steps:
        told += f". Next: {', then '.join(steps)}"
    if keys:
        told += f". What of {', '.join(keys)} no calibration finds is yours to write"
    return told


def _bases(profile: Profile) -> list[Path]:
    """Return the files that a profile extends, without its calibrations."""
    overlays = tuple(calibration.file for calibration in profile.calibrations.values())
    return [file for file in profile.files[1:] if not (overlays and str(file).endswith(overlays))]


def _keys_in(name: str, file: Path, profile: Profile) -> list[str]:
    """Return what of a setting stands in a file: all of it, or those of its keys that do."""
    prefix = f"{profile.mechanism}."
    below = [key for key in profile.places if key.startswith(f"{prefix}{name}.")]
    keys = [key for key in below if profile.places[key].startswith(f"{file}:")]
    if keys == below:  # or it has none: then it counts where it stands itself
        return [name] if _stands_in(f"{prefix}{name}", file, profile) else []
    return [key.removeprefix(prefix) for key in keys]


def _stands_in(prefix: str, file: Path, profile: Profile) -> bool:
    """Return whether a file says a key, or one below it."""
    return any(
        place.startswith(f"{file}:")
        for key, place in profile.places.items()
        if key.startswith(prefix)
    )


def _other_dimensions(
    profile: Profile, base: Path, search: Sequence[Path], dimensions: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """Yield the dimensions that are others in a file, and both values in a sentence."""
    from rig.config.document import plain_under
    from rig.config.quantities import parse_quantity
    from rig.config.type_hints import hints, unit_of
    from rig.hal.formats import format_quantity

    settings: type = type(profile.mechanism_settings)
    annotations = hints(settings)
    said = plain_under(profile.mechanism, base, "rigs", search)
    if not isinstance(said, dict):
        return
    for name in dimensions:
        unit, there = unit_of(annotations[name]) or "1", said.get(name)
        here = getattr(profile.mechanism_settings, name)
        if isinstance(there, str):
            there = parse_quantity(there, unit)
        if isinstance(there, int | float) and there != here:
            yield (
                name,
                (
                    f"{profile.mechanism}.{name} is {format_quantity(there, unit)} "
                    f"({format_quantity(here, unit)} here)"
                ),
            )
