"""The log columns that mechanisms on servo axes have in common."""

from collections.abc import Sequence

from rig.hal.columns import Column


def servo_columns(names: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns of joints with these names, as `ServoAxes.joint_row` fills them."""

    def each(prefix: str, unit: str, text: str) -> list[Column]:
        return [Column(f"{prefix}_{name}", unit, text.format(name)) for name in names]

    return (
        *each("reading.position", "rad", "position of {}"),
        *each("reading.velocity", "rad/s", "velocity of {} as its drive gives it"),
        Column("reading.age", "s", "age of the oldest reading when it was used"),
        *each("reference.position", "rad", "planned position of {}"),
        *each("reference.velocity", "rad/s", "planned velocity of {}"),
        *each("command.position", "rad", "position that the law wants of {}"),
        *each("command.velocity", "rad/s", "velocity that the law wants of {}"),
        *each("applied.position", "rad", "position that was sent to {}"),
        *each("applied.velocity", "rad/s", "velocity of what was sent to {}"),
    )
