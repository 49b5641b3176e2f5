"""What is known of all poses of the joint beforehand: each number's unit and meaning."""

from collections.abc import Mapping
from typing import Final

from rig.hal.motion import FactKind

TOLD: Final = (20.0, 40.0, 60.0)
"""Tilts for which the paper's errors are told, degrees."""

JOINT_FACTS: Final[Mapping[str, FactKind]] = {
    "reachable_tilt": FactKind("rad", "tilt that is reached in every direction"),
    "reachable_tilt_best": FactKind("rad", "tilt that is reached in the best direction"),
    **{
        f"{name}_{degrees:g}deg": FactKind(unit, f"{text} at {degrees:g} deg of tilt")
        for degrees in TOLD
        for name, unit, text in (
            ("paper_wire_error", "m", "greatest error of the paper's wires"),
            (
                "paper_pose_gap",
                "m",
                "greatest difference of a wire between the paper's pose and the natural one",
            ),
            ("paper_twist", "rad", "greatest twist of the paper's pose"),
        )
    },
}
