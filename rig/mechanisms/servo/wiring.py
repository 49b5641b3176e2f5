"""Which device has which axis."""

from collections.abc import Sequence

from rig.hal import ServoBus, SeveralErrors


def wire_axes(
    names: Sequence[str], servos: Sequence[ServoBus]
) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
    """Return where each joint stands among the devices' readings, and each device's joints."""
    offered = [(name, servo.name) for servo in servos for name in servo.axis_names]
    found = [name for name, _ in offered]
    wrong: list[str] = []
    for k, (name, device) in enumerate(offered):
        if name not in names:
            wrong.append(
                f"{device}: the mechanism has no joint {name!r}; it has {', '.join(names)}"
            )
        if found.count(name) > 1 and found.index(name) == k:
            wrong.append(f"{device}: two drives move the joint {name!r}")
    for name in names:
        if name not in found:
            wrong.append(f"no servo device has the joint {name!r}; they have {', '.join(found)}")
    SeveralErrors.raise_if_any(wrong)
    index = {name: k for k, name in enumerate(names)}
    return (
        tuple(found.index(name) for name in names),
        tuple(tuple(index[name] for name in servo.axis_names) for servo in servos),
    )
