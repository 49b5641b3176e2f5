"""A walk over footprints that are given one by one: in a file, in the experiment, or by numbers."""

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from annotated_types import MaxLen

from controllers.gait.footprints import MOST_STEPS, Footstep, StepNumbers, SteppingSettings
from controllers.gait.footstep_file import lines_of_steps, read_footsteps
from controllers.gait.footstep_numbers import number_footsteps
from controllers.gait.footstep_plan import plan_footsteps
from controllers.gait.geometry import LegGeometry
from controllers.gait.ground_plane import GroundPlane
from controllers.gait.motions import SquatSettings, WalkSettings
from controllers.gait.phases import GaitPhase
from controllers.motion import InfeasibleMotion

_STEP = re.compile(
    r"\b(?:(?:step|swing (?:right|left)) (?P<step>\d+)|shift (?P<shift>\d+))\b(?! \([^)]*line \d)"
)


@dataclass(frozen=True, slots=True)
class FootstepsSettings(SteppingSettings):
    """A walk over given footprints, in balance at every instant.

    The waist goes in a straight line from over one ankle to over the next while both feet stand,
    turning to where the standing foot points, and rests while a foot swings. Both feet begin under
    the hips, on one plane, and in the end the waist is midway between them.

    Parameters
    ----------
    file : Path, optional
        A CSV file of footprints. Its header names each column with its unit: ``foot, x (mm),
        y (mm)`` and, where they matter, ``heading (deg), height (mm), pitch (deg), roll (deg),
        lift (mm), shift (s), swing (s)``; a row for each footprint, in their order.
    steps : tuple of Footstep
        Instead of a file.
    numbers : StepNumbers, optional
        Instead of both.

    Raises
    ------
    ValueError
        Not exactly one of `file`, `steps` and `numbers` is given.
    """

    file: Path | None = None
    steps: Annotated[tuple[Footstep, ...], MaxLen(MOST_STEPS)] = ()
    numbers: StepNumbers | None = None

    def __post_init__(self) -> None:
        if (self.file is not None) + bool(self.steps) + (self.numbers is not None) != 1:
            raise ValueError("give exactly one of file, steps and numbers.")

    def footsteps(self, geometry: LegGeometry) -> tuple[Footstep, ...]:
        """Return the footprints in their order.

        Raises
        ------
        InfeasibleMotion
            The file cannot be read, with line, column and what is wrong there.
        """
        if self.file is not None:
            return read_footsteps(Path(self.file))
        ground = GroundPlane(self.start_pitch, self.start_roll)
        return self.steps or number_footsteps(geometry, self.numbers or StepNumbers(), ground)

    def with_line(self, message: str) -> str:
        """Return a message with the line of the file for each step or phase that it names.

        A shift is told with the step that it leads to, the last one with the last step.
        """
        if self.file is None:
            return message
        file = Path(self.file)
        try:
            lines = lines_of_steps(file)
        except InfeasibleMotion:
            return message  # of the file itself
        named = f"{file.name}, "

        def put(found: re.Match[str]) -> str:
            nonlocal named
            number = int(found["step"] or int(found["shift"]) + 1)
            words = f"{found[0]} ({named}line {lines[min(number, len(lines)) - 1]})"
            named = ""
            return words

        return _STEP.sub(put, message)

    def phases(self, geometry: LegGeometry, min_margin: float = -math.inf) -> tuple[GaitPhase, ...]:
        """Return the phases of the walk, in their order.

        Parameters
        ----------
        geometry : LegGeometry
            The legs.
        min_margin : float
            Least distance of the centre of mass from the edge of what the feet stand on, m.

        Raises
        ------
        InfeasibleMotion
            A step cannot be done, with its number and line, and what could.
        """
        try:
            return plan_footsteps(geometry, self, self.footsteps(geometry), min_margin)
        except InfeasibleMotion as error:
            raise InfeasibleMotion(self.with_line(str(error))) from error

    def advance(self, geometry: LegGeometry) -> float:
        """Return how far the waist is to go ahead, m."""
        phases = self.phases(geometry)
        return phases[-1].waist_at(1.0)[0] - phases[0].waist[0]


LegsMotion = WalkSettings | SquatSettings | FootstepsSettings
"""Any motion that a law can prepare."""


def phases_of(
    motion: LegsMotion, geometry: LegGeometry, min_margin: float
) -> tuple[GaitPhase, ...]:
    """Return the phases of a motion; footprints over which the robot would tip over are refused.

    Parameters are those of `FootstepsSettings.phases`.

    Raises
    ------
    InfeasibleMotion
        It cannot be done, with what could.
    """
    if isinstance(motion, FootstepsSettings):
        return motion.phases(geometry, min_margin)
    return motion.phases(geometry)
