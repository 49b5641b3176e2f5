"""The procedures of a rig."""

from rig.assembly import REGISTRY
from rig.calibration.procedure import AnyProcedure, Procedure
from rig.config import Profile
from rig.hal import ConfigurationError


def procedures(profile: Profile) -> dict[str, AnyProcedure]:
    """Return the procedures of a rig by name, in the order in which they build on each other.

    Raises
    ------
    ConfigurationError
        Two packages have one of the same name.
    """
    found: dict[str, AnyProcedure] = {}
    path_of: dict[str, str] = {}
    for path, procedure in REGISTRY.procedures(profile.mechanism, Procedure).items():
        if procedure.targets(profile):
            name = procedure.name
            if (first := path_of.setdefault(name, path)) != path:
                raise ConfigurationError(
                    f"two packages have a procedure {name!r}: {first} and {path}"
                )
            found[name] = procedure
    return found


def pick(profile: Profile, names: tuple[str, ...]) -> list[AnyProcedure]:
    """Return procedures by name, in their own order.

    Raises
    ------
    ConfigurationError
        There is none of a name; with the nearest.
    """
    from rig.config.diagnostics import nearest

    known = procedures(profile)
    for name in names:
        if name not in known:
            hint = nearest(name, known) or f"there is none for a {profile.mechanism}"
            raise ConfigurationError(f"no procedure of {profile.name} is called {name!r}; {hint}")
    return [procedure for name, procedure in known.items() if name in names]
