"""Say where a law is that an experiment, an option or a question names in vain."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from rig.config.diagnostics import nearest
from rig.config.document import plain_under
from rig.config.named_settings import Registry
from rig.config.names import list_files


def hint_of_law(
    name: str, rig: str | None, known: Iterable[str], registry: Registry, search: Sequence[Path]
) -> str | None:
    """Return a hint for a law that a rig has not: who has it, or what is like it.

    Parameters
    ----------
    name : str
        What is asked for.
    rig : str, optional
        The rig that has it not.
    known : iterable of str
        The laws that the rig has.
    registry : Registry
        Tells what packages offer that no profile has named.
    search : sequence of Path
        The configuration folders.
    """
    profiles = profiles_with_law(name, search)
    if profiles and rig not in profiles:
        return f"the rig {' or '.join(profiles)} has it: --rig {profiles[0]}"
    return hint_of_additions(registry, nearest(name, known))


def profiles_with_law(name: str, search: Sequence[Path]) -> tuple[str, ...]:
    """Return the names of the profiles whose `controllers` have an entry; no code of it runs."""
    found = []
    for rig, file in list_files("rigs", search).items():
        controllers = plain_under("controllers", file, "rigs", search)
        if isinstance(controllers, dict) and name in controllers:
            found.append(rig)
    return tuple(found)


def hint_of_additions(registry: Registry, hint: str | None) -> str | None:
    """Return a hint for a name that there is not: it may be of additions, which are named."""
    unnamed = ", ".join(registry.unnamed())
    if not unnamed:
        return hint
    more = f"a profile's additions: [NAME] lets a package take part: {unnamed}"
    return more if hint is None else f"{hint}; {more}"
