"""What one recorded number is called, and the message type that a row of them makes."""

import re
from collections.abc import Sequence
from typing import NamedTuple

SCHEMA_NAME = "rig_msgs/msg/Cycle"
RESERVED = ("stamp", "cycle", "t", "checksum")
"""Fields that every message has, so no column may be called so."""

_FIELD_NAME = re.compile(r"^(?!.*__)(?!.*_$)[a-z][a-z0-9_]{0,99}$")
"""ROS 2's rule for field names: each part of a dotted column name becomes a field."""


_MOST = 4096
"""Columns of a log; the joint's has a hundred, and a row of more takes longer than a cycle."""


class Column(NamedTuple):
    """One recorded quantity.

    Parameters
    ----------
    name : str
        Dotted name, e.g. ``"reading.position"``: the part before the dot is the group.
    unit : str
        SI unit, e.g. ``"m"``; empty for a number without one.
    description : str
        One line for whoever opens the log without this program.
    """

    name: str
    unit: str
    description: str


def group_order(columns: Sequence[Column]) -> tuple[int, ...]:
    """Return the indices that put the columns of each group side by side.

    Groups come in the order of their first column, and columns keep their order in a group.
    """
    tops = [column.name.partition(".")[0] for column in columns]
    rank = {top: number for number, top in reversed(list(enumerate(tops)))}
    return tuple(sorted(range(len(columns)), key=lambda index: rank[tops[index]]))


def schema_text(columns: Sequence[Column]) -> str:
    """Compose the ROS 2 message definition of a row.

    A dotted name becomes a nested message: ``reading.position`` is the field ``position`` of
    the field ``reading`` of type ``Reading``. Every comment ends with the unit in brackets,
    which is how ROS tools look for it.

    Parameters
    ----------
    columns : sequence of Column
        In the order of the message's bytes, so those of a group side by side (`group_order`).

    Returns
    -------
    str
        The definition and those of its nested types, as ``ros2msg`` wants them.

    Raises
    ------
    ValueError
        A name is not a legal field name, is used twice, or its group is split.
    """
    check_columns(columns)
    fields = [
        "builtin_interfaces/Time stamp  # wall-clock time of the cycle",
        "uint64 cycle  # number of the cycle since the rig was armed",
        "float64 t  # time of the cycle on the rig's own clock [s]",
    ]
    groups: dict[str, list[str]] = {}
    for column in columns:
        group, dot, field = column.name.rpartition(".")
        if not dot:
            fields.append(_field(field, column))
            continue
        if group not in groups:
            groups[group] = []
            fields.append(f"{_type_name(group)} {group}")
        groups[group].append(_field(field, column))
    fields.append("uint32 checksum  # CRC-32 of the record, begun with all before the first")
    definitions = ["\n".join(fields)]
    for group, members in groups.items():
        definitions.append(f"MSG: rig_msgs/{_type_name(group)}\n" + "\n".join(members))
    definitions.append("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec")
    return ("\n" + "=" * 80 + "\n").join(definitions) + "\n"


def _field(name: str, column: Column) -> str:
    description = " ".join(column.description.split())
    unit = f" [{column.unit}]" if column.unit else ""
    return f"float64 {name}  # {description}{unit}"


def _type_name(group: str) -> str:
    return "".join(word.capitalize() for word in group.split("_"))


def check_columns(columns: Sequence[Column]) -> None:
    """Refuse what no file, table or terminal should meet as the name of a column.

    Raises
    ------
    ValueError
        There are too many, a name is not a legal field name, is used twice, or its group is split,
        or a unit or a description is no line of text.
    """
    if len(columns) > _MOST:
        raise ValueError(f"{len(columns)} columns, expected at most {_MOST}")
    names: set[str] = set()
    types: dict[str, str] = {}
    tops: list[str] = []
    for column in columns:
        if not column.unit.isprintable() or not " ".join(column.description.split()).isprintable():
            raise ValueError(f"column {column.name!r}: its unit or description is no line of text")
        parts = column.name.split(".")
        if len(parts) > 2 or not all(_FIELD_NAME.match(part) for part in parts):
            raise ValueError(
                f"column {column.name!r}: a name is one or two parts of lower-case letters, "
                "digits and single underscores, joined by a dot"
            )
        top = parts[0]
        if top in RESERVED:
            raise ValueError(f"column {column.name!r}: {top!r} is part of every message")
        if column.name in names:
            raise ValueError(f"column {column.name!r} is there twice")
        if len(parts) == 2 and types.setdefault(_type_name(top), top) != top:
            raise ValueError(f"groups {types[_type_name(top)]!r} and {top!r} are too alike")
        if top in tops and (top in names or len(parts) == 1):
            raise ValueError(f"{top!r} is both a column and a group")
        if top in tops[:-1]:
            raise ValueError(f"column {column.name!r} stands apart from its group {top!r}")
        if top not in tops:
            tops.append(top)
        names.add(column.name)
