"""The meaning of what is true of a simulated plant, column by column."""

import re
from typing import Final

_MEANINGS: Final = (
    (r"position", "where the carriage truly is, from home"),
    (r"velocity", "how fast the carriage truly goes"),
    (r"extension_(\w+)", "how far the rod of {0} truly is out"),
    (r"speed_(\w+)", "how fast the rod of {0} truly goes out"),
    (r"pressure_(\w+)", "true pressure in the chamber of {0}, gauge"),
    (r"ring_tension_(\w+)", "true tension of the wire of {0} on the ring's side of the ball"),
    (r"tension_(\w+)", "true tension of the wire of {0} on its cylinder's side"),
    (r"sticking_(\w+)", "1 while the seals of {0} truly hold its rod, 0 while they slide"),
    (r"supply", "true pressure of the supply, gauge"),
    (r"marker_([xyz])", "true {0} of the marker that the camera looks at"),
    (r"axis_([xyz])", "true {0} of the unit vector along the ring's axis"),
    (r"twist", "true twist of the ring about its axis"),
    (r"hand_([xyz])", "true {0} of the hand"),
    (r"waist_([xyz])", "true {0} of the waist"),
    (r"waist_(roll|pitch|yaw)", "true {0} of the waist"),
    (r"(right|left)_foot_([xyz])", "true {1} of the sole of the {0} foot"),
    (r"advance", "how far the waist has truly come since the stand let go"),
    (r"slip_(right|left)", "how far the {0} foot has truly slipped from where it came down"),
    (r"load_(right|left)", "true force of the floor on the {0} foot"),
    (r"saturated", "how many servos truly are at their peak torque or speed"),
    (r"fell", "1 from when the robot has truly fallen"),
    (r"torque_(\w+)", "true torque of the drive at {0}"),
)
"""Whole names as patterns, and what they mean; of others the unit tells."""


def true_meaning(name: str, unit: str) -> str:
    """Return what a column of a plant's truth means.

    Parameters
    ----------
    name : str
        Of the plant's `truth_columns`.
    unit : str
        Its unit.
    """
    for pattern, meaning in _MEANINGS:
        found = re.fullmatch(pattern, name)
        if found is not None:
            return f"{meaning.format(*found.groups())}, in the simulated plant"
    if unit == "rad/s":
        return f"true speed of {name.removesuffix('_velocity')}, in the simulated plant"
    if unit == "rad":
        return f"true angle of {name}, in the simulated plant"
    return f"true value of {name}, in the simulated plant"
