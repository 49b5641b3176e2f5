"""What a thing lacks of a protocol: asked once, where the thing is loaded or picked."""

import functools


@functools.cache
def members_of(protocol: type) -> tuple[tuple[str, bool], ...]:
    """Return the names that a protocol asks for, and whether instances alone need have them."""
    found: dict[str, bool] = {}
    for base in protocol.__mro__:
        if base.__module__ in ("builtins", "typing"):
            continue
        own = vars(base)
        found |= {
            name: isinstance(member, property)
            for name, member in own.items()
            if not name.startswith("_")
        }
        for name in own.get("__annotations__", {}):
            if not name.startswith("_"):
                found.setdefault(name, True)
    return tuple(sorted(found.items()))


def lacking(thing: object, protocol: type) -> tuple[str, ...]:
    """Return the members of a protocol that a class or an instance of one does not have.

    What a class only inherits from the protocol itself, without a default, it does not have. What
    the protocol annotates or has as a property may be set by a constructor: a class need not have
    it, if its instances do.
    """
    kind = thing if isinstance(thing, type) else type(thing)
    unwritten = kind.__dict__.get("__abstractmethods__", frozenset())
    return tuple(
        name
        for name, of_instances in members_of(protocol)
        if name in unwritten
        or not (hasattr(kind, name) or (thing is kind and of_instances) or hasattr(thing, name))
    )
