"""What the procedures of pneumatic cylinders need to know of a mechanism."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any, ClassVar, Generic, TypeVar

from controllers.cylinder.types import PairReference
from rig.calibration.arrays import Array
from rig.calibration.procedure import Excitation, Procedure
from rig.calibration.profile_changes import profile_with
from rig.calibration.recording import Recording, RigLacks, Stretch
from rig.calibration.sequence import ScriptedMotion
from rig.config import Profile, format_quantity
from rig.hal.motion import Motion
from rig.mechanisms.pneumatic.calibration.pressure_steps import PressureSteps, TogetherByClock

Reference = TypeVar("Reference")
Command = TypeVar("Command", bound=tuple[float, ...])

_SLOW = 2.0
"""Regulators down to a third of the bandwidth that the profile says are no fault meanwhile."""
_STEP = 0.01
"""A path is looked at every so often for the preview, s."""

Limit = tuple[str, float | tuple[float, float], str]
"""Name, bound or bounds, and SI unit."""


class Pneumatics(ABC, Generic[Reference, Command]):
    """A mechanism whose rods are pulled by pneumatic cylinders, as a profile has it.

    Parameters
    ----------
    profile : Profile
        The rig's.
    """

    locked_share: ClassVar[float]
    """Share of the permitted way that rods go where their air is locked in; friction holds them."""

    def __init__(self, profile: Profile) -> None:
        self.profile = profile
        settings = profile.mechanism_settings
        self.area: float = settings.area
        self.stroke: float = settings.stroke
        self.base_pressure: float = settings.base_pressure
        self.regulators: str = settings.regulators
        self.channels: tuple[str, ...] = tuple(profile.devices[self.regulators].settings.channels)
        low, high = self._pressures()
        self.lowest = low + 0.06 * (high - low)
        """Pressure that every chamber may have at once, at least; Pa gauge."""
        self.highest = high - 0.08 * (high - low)
        """The same at most."""

    # Devices and columns ----------------------------------------------------------------

    @property
    @abstractmethod
    def encoders(self) -> tuple[str, ...]:
        """The rods' encoders, in the order of the channels."""

    @abstractmethod
    def extension(self, stretch: Stretch, channel: str) -> Array:
        """Return how far a rod stands out by its encoder, m, shape (n,)."""

    # Limits -----------------------------------------------------------------------------

    @abstractmethod
    def _pressures(self) -> tuple[float, float]:
        """Return the pressures that a chamber may have, Pa gauge."""

    @abstractmethod
    def limits_in_force(self) -> Iterator[Limit]:
        """Yield the limits that the preview shows."""

    def with_unknown_response(
        self, profile: Profile, notes: Sequence[str]
    ) -> tuple[Profile, tuple[str, ...]]:
        """Return a profile that permits slow regulators, and its notes.

        Whatever is calibrated may come before `response`, which tells how slow they are.
        """
        slow = {f"{profile.mechanism}.alarms.pressure.slow": _SLOW}
        note = f"alarms.pressure.slow is {_SLOW:g}: how slow regulators are may not be known yet"
        return profile_with(profile, slow), (*notes, note)

    @abstractmethod
    def with_wider_limits(self, pair: float = 0.0) -> tuple[Profile, tuple[str, ...]]:
        """Return the profile with limits that rest on what is looked for, and notes on them.

        Parameters
        ----------
        pair : float
            By how much more than usual the two rods of a pair may disagree, m.
        """

    @abstractmethod
    def with_blind_monitors(self, give: float) -> tuple[Profile, tuple[str, ...]]:
        """Return the profile for chambers that no monitor sees for a while, and notes on it.

        Parameters
        ----------
        give : float
            How far a wire may seem to move meanwhile, m.
        """

    def need_regulators(self, why: str) -> None:
        """Refuse a rig on proportional valves.

        Raises
        ------
        RigLacks
            It is one; says why that does not do.
        """
        if self.profile.mechanism_settings.valves is not None:
            raise RigLacks(f"{self.regulators} has proportional valves; {why}")

    # Motion -----------------------------------------------------------------------------

    @property
    @abstractmethod
    def gentle_pressure(self) -> float:
        """Base pressure under which the rods are moved from place to place, Pa gauge."""

    @abstractmethod
    def with_gentle_controller(self) -> tuple[Profile, str]:
        """Return the profile with a controller that is at rest at its place, and its name."""

    @abstractmethod
    def with_placing_controller(self) -> tuple[Profile, str]:
        """Return the profile with a controller that takes rods to a caliper, and its name.

        It knows nothing of wires that rods are calibrated against.
        """

    @abstractmethod
    def reach(self, share: float) -> float:
        """Return how far a pair, or a ring along its ball, may go from home, m.

        Parameters
        ----------
        share : float
            Of what is permitted.
        """

    @abstractmethod
    def along_line(
        self,
        motion: Motion[PairReference],
        controller: object,
        bases: Sequence[tuple[float, float]] = (),
    ) -> Motion[Reference]:
        """Return a motion along a line as one of the mechanism.

        Parameters
        ----------
        motion : Motion of PairReference
            Settings of a reference of a pair: positions of wires, m.
        controller : object
            Who is to follow it.
        bases : sequence of tuple of float
            From when on (s) which base pressure (Pa gauge); a pair keeps its own.

        Raises
        ------
        MotionRefused
            The mechanism cannot be or may not be somewhere along it.
        """

    @abstractmethod
    def describe_path(self, path: Sequence[Reference]) -> Iterator[str]:
        """Yield how far references go, and how fast."""

    @property
    @abstractmethod
    def still(self) -> Reference:
        """The reference to stay at home."""

    @property
    @abstractmethod
    def no_estimate(self) -> object:
        """What the log keeps of a controller that believes nothing."""

    @property
    @abstractmethod
    def command(self) -> Callable[..., Command]:
        """What makes a command of one pressure per channel."""

    @abstractmethod
    def balanced(self, reference: Reference, pressure: float) -> tuple[float, ...]:
        """Return pressures that hold a pose by themselves, Pa gauge.

        Parameters
        ----------
        reference : Reference
            The pose.
        pressure : float
            Their mean, as far as none gets above what is permitted, Pa gauge.
        """

    # Excitations ------------------------------------------------------------------------

    def describe(self, motion: Motion[Reference]) -> Iterator[str]:
        """Yield how far a motion goes, and how fast."""
        count = max(int(motion.duration / _STEP), 2)
        return self.describe_path(
            [motion.at(motion.duration * k / count) for k in range(count + 1)]
        )

    def excitation(
        self,
        settings: object,
        motion: Motion[Reference],
        controller: object,
        name: str,
        notes: Sequence[str],
        approach: float,
    ) -> Excitation:
        """Return a motion that a controller of the profile follows; see `Excitation`."""
        return Excitation(
            settings, motion, controller, name, self.profile,
            lambda: chain(self.describe(motion), self._describe_limits()), notes, approach,
        )  # fmt: skip

    def scripted(
        self,
        settings: object,
        script: ScriptedMotion[Any, Any, Any],
        name: str,
        notes: Sequence[str],
        approach: float,
        *,
        follows: bool = False,
    ) -> Excitation:
        """Return a script, which is its own controller; see `Excitation`.

        Parameters
        ----------
        follows : bool
            Whether it follows a path besides what it describes itself.
        """

        def describe() -> Iterator[str]:
            path = self.describe(script) if follows else ()
            return chain(path, script.describe(), self._describe_limits())

        return Excitation(settings, script, script, name, self.profile, describe, notes, approach)

    def together(self, steps: PressureSteps, room: float, approach: float) -> Excitation:
        """Return pressures that all chambers are given alike, without a controller.

        Parameters
        ----------
        steps : PressureSteps
            The pressures.
        room : float
            By how much more than usual the two rods of a pair may disagree, m.
        approach : float
            Time to go to the first pressure, s.
        """
        profile, notes = self.with_wider_limits(room)
        script = TogetherByClock(
            steps, self.base_pressure, len(self.channels),
            still=self.still, command=self.command, estimate=self.no_estimate,
        )  # fmt: skip
        return type(self)(profile).scripted(steps, script, "open-loop", notes, approach)

    def _describe_limits(self) -> Iterator[str]:
        for name, bound, unit in self.limits_in_force():
            ends = bound if isinstance(bound, tuple) else (bound,)
            shown = " … ".join(format_quantity(end, unit) for end in ends)
            yield f"in force: limits.{name} {shown}"


AnyPneumatics = Pneumatics[Any, Any]


class PneumaticProcedure(Procedure[Recording]):
    """A procedure for every mechanism on pneumatic cylinders.

    Parameters
    ----------
    pneumatics : callable
        The mechanism's `Pneumatics`.
    """

    def __init__(self, pneumatics: Callable[[Profile], AnyPneumatics]) -> None:
        self._of = pneumatics
