"""What a profile says of the rig that something was measured on, and what of it is another now.

A calibration keeps it by the procedure that measured, as texts with units, so that a file says it
to people as well. What calibrations have laid over the profile is no part of it: it was measured,
and each of them answers for its own. So does what it has laid something over: who writes another
value there means another part, and it would not be in force.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fnmatch import fnmatchcase

from rig.config.located import Plain
from rig.config.models import Calibration, Profile
from rig.config.type_hints import hint_at, unit_of
from rig.hal.formats import unit_for_people

_MOST = 3
"""So many changes are told one by one."""


def stated(profile: Profile, keys: Sequence[str]) -> dict[str, str]:
    """Return what a profile says without its calibrations, by dotted names.

    Parameters
    ----------
    profile : Profile
        As loaded.
    keys : sequence of str
        What to return: dotted names of values or sections; ``*`` stands for any one of a section.
    """
    return _said(
        {
            "loop": profile.loop,
            profile.mechanism: profile.nominal_settings,
            **{f"devices.{name}": entry.nominal for name, entry in profile.devices.items()},
        },
        keys,
    )


def _in_force(profile: Profile, keys: Sequence[str]) -> dict[str, str]:
    """Return what holds with all calibrations laid over, as `stated` does without them."""
    devices = {f"devices.{name}": entry.settings for name, entry in profile.devices.items()}
    return _said({profile.mechanism: profile.mechanism_settings, **devices}, keys)


def _said(sections: Mapping[str, object], keys: Sequence[str]) -> dict[str, str]:
    wanted = [key.split(".") for key in keys]
    return {
        name: text
        for section, settings in sections.items()
        for name, text in _leaves(section, settings, type(settings))
        if any(_is_below(name.split("."), key) for key in wanted)
    }


def changes_of(calibration: Calibration, profile: Profile) -> dict[str, tuple[str, ...]]:
    """Return what is another value in a profile than when it was measured, by procedure.

    Parameters
    ----------
    calibration : Calibration
        What was measured; one that does not say what the profile was then has no changes.
    profile : Profile
        As it is now. What it has no more cannot be compared.

    Returns
    -------
    dict of str to tuple of str
        Sentences such as ``"cylinder.bore 16 mm, and the profile says 32 mm"``; procedures that
        nothing has changed under are left out.
    """
    basis = by_procedure(calibration.provenance.basis)
    if not basis:
        return {}
    keys = [key for before in basis.values() for key in before]
    now, in_force = stated(profile, keys), _in_force(profile, keys)
    measured = set(_measured(profile, others_than=calibration))
    # Who copies what was found into the profile changes nothing.
    measured |= {key for key in _measured(profile) if now.get(key) == in_force.get(key)}
    found = {
        procedure: tuple(
            f"{key} {was}, and the profile says {now[key]}"
            for key, was in before.items()
            if key in now and now[key] != was and key not in measured
        )
        for procedure, before in basis.items()
    }
    return {procedure: changes for procedure, changes in found.items() if changes}


def by_procedure(kept: Mapping[str, Mapping[str, str]]) -> dict[str, Mapping[str, str]]:
    """Return what each procedure rests on, of what a file keeps of several at once."""
    return {name: its for names, its in kept.items() for name in names.split(", ")}


def kept_once(of: Mapping[str, Mapping[str, str]]) -> dict[str, dict[str, str]]:
    """Return what procedures rest on as a file keeps it: once where it is the same."""
    found: dict[str, dict[str, str]] = {}
    for its in of.values():
        names = ", ".join(name for name, other in of.items() if other == its)
        if its:
            found[names] = dict(its)
    return found


def say_changes(changes: Mapping[str, Sequence[str]]) -> str:
    """Return the changes of procedures as the rest of a sentence on what they have found."""
    found = list(dict.fromkeys(change for its in changes.values() for change in its))
    more = f"; and {len(found) - _MOST} more" if len(found) > _MOST else ""
    return f"found with {'; '.join(found[:_MOST])}{more}"


def _is_below(name: Sequence[str], key: Sequence[str]) -> bool:
    return len(name) >= len(key) and all(map(fnmatchcase, name, key))


def _measured(profile: Profile, others_than: Calibration | None = None) -> Iterator[str]:
    """Yield the names of the values that calibrations have laid over a profile."""
    for name, calibration in profile.calibrations.items():
        if calibration is others_than:
            continue
        section = name if name == profile.mechanism else f"devices.{name}"
        yield from _names(section, calibration.replaced)


def _names(section: str, values: Plain) -> Iterator[str]:
    if isinstance(values, dict):
        for key, below in values.items():
            yield from _names(f"{section}.{key}", below)
    else:
        yield section


def _leaves(section: str, value: object, hint: object) -> Iterator[tuple[str, str]]:
    if is_dataclass(value):
        below: Mapping[str, object] = {
            field.name: getattr(value, field.name) for field in fields(value) if field.init
        }
    elif isinstance(value, dict):
        below = value
    else:
        yield section, say(value, hint)
        return
    for key, item in below.items():
        yield from _leaves(f"{section}.{key}", item, hint_at(hint, (str(key),)))


def say(value: object, hint: object) -> str:
    """Return a value with its unit as text, to nine digits: it is compared with itself.

    Parameters
    ----------
    value : object
        In SI.
    hint : annotation
        Of the setting, with its unit.
    """
    if isinstance(value, list | tuple):
        texts = [say(item, hint_at(hint, (number,))) for number, item in enumerate(value)]
        return ", ".join(texts) or "none"
    if isinstance(value, float):
        name, scale = unit_for_people(value, unit_of(hint) or "1")
        return f"{value / scale:.9g} {name}".rstrip()
    if value is None:
        return "none"
    return str(value).lower() if isinstance(value, bool) else str(value)
