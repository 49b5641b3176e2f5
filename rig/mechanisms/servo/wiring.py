"""Which device has which axis."""

from collections.abc import Sequence

from rig.hal import ConfigurationError, ServoBus


def wire_axes(
    names: Sequence[str], servos: Sequence[ServoBus]
) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
    """Return where each joint stands among the devices' readings, and each device's joints."""
    offered = [(name, servo.name) for servo in servos for name in servo.axis_names]
    found = [name for name, _ in offered]
    for name, device in offered:
        if name not in names:
            raise ConfigurationError(
                f"{device}: the mechanism has no joint {name!r}; it has {', '.join(names)}"
            )
        if found.count(name) > 1:
            raise ConfigurationError(f"{device}: two drives move the joint {name!r}")
    for name in names:
        if name not in found:
            raise ConfigurationError(
                f"no servo device has the joint {name!r}; they have {', '.join(found)}"
            )
    index = {name: k for k, name in enumerate(names)}
    return (
        tuple(found.index(name) for name in names),
        tuple(tuple(index[name] for name in servo.axis_names) for servo in servos),
    )
