"""The seam between the loop, which is the same for every rig, and a mechanism."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeVar

from rig.hal.closed_loop import ClosedLoop
from rig.hal.columns import Column
from rig.hal.controller import Law
from rig.hal.devices import Device
from rig.hal.driver import AxisBounds
from rig.hal.errors import ConfigurationError
from rig.hal.freeze import Freeze
from rig.hal.hindsight import Hindsight
from rig.hal.motion import Motion
from rig.hal.quantities import Expected, Margin
from rig.hal.standing import Standing
from rig.hal.stop_input import EmergencyStopInput
from rig.hal.targets import Targets

Settings = TypeVar("Settings")
State = TypeVar("State")
Reference = TypeVar("Reference")
Command = TypeVar("Command")


class Mechanism(
    Hindsight[Settings], Standing[State], Protocol[Settings, State, Reference, Command]
):
    """The loop's view of a rig's mechanics.

    The loop calls, each cycle and in this order: `read`, `check`, (the controller), `limit`,
    `write`, `row`. Inherit it: what has a default need not be written.
    """

    columns: Sequence[Column]

    law: ClassVar[type] = Law
    """What its laws must offer beside `Law`: a protocol or base that asks for more."""

    stopping_time: float = 0.0
    """How long the rig takes to come to rest after a fault, s: for so long the log goes on."""

    venting_time: float = 0.0
    """How long nothing is taken for safe, s: monitors that are off or broken say so too early."""

    varies_with: ClassVar[Mapping[str, Sequence[str]]] = {}
    """Keys of what has to be measured anew, by the key of the dimension with which it changes."""

    dimensions: ClassVar[Sequence[str]] = ("geometry",)
    """Keys of what calibrations of the mechanism rest on, and do not hold without."""

    believed: ClassVar[Sequence[str]] = ()
    """Keys of what gains that were found for a law rest on besides `dimensions`."""

    brakes_itself: bool = False
    """Whether `balanced_command` brings a motion to rest, and control need not do it before."""

    @classmethod
    @abstractmethod
    def assemble(
        cls, settings: Settings, devices: Mapping[str, Device], period: float
    ) -> "Mechanism[Settings, State, Reference, Command]":
        """Pick the devices that the settings name.

        Parameters
        ----------
        settings : object
            The mechanism's section of the profile.
        devices : mapping
            The rig's devices by name.
        period : float
            The loop's period, s.

        Raises
        ------
        ConfigurationError
            A device is not there, or cannot do what its role asks for (`pick_device`).
        """

    @classmethod
    def wiring(cls, settings: Settings) -> Mapping[str, str]:
        """Return which channel of the plant each device measures that has no names for its own."""
        return {}

    @classmethod
    def geometry_of(cls, settings: Settings) -> object | None:
        """Return the geometry that the plant is made with, beside its own settings; if any."""
        return None

    @classmethod
    def limits_of(cls, settings: Settings) -> object | None:
        """Return the dataclass of limits that `rig check` shows; if any."""
        return None

    @classmethod
    def expected_of(cls, settings: Settings) -> tuple[Expected, ...]:
        """Return what else `rig check` shows: what the settings lead to if something breaks."""
        return ()

    def in_force(self, settings: Settings) -> Settings:
        """Return settings with what the devices say where the profile says nothing."""
        return settings

    @classmethod
    def described(cls, settings: Settings) -> tuple[tuple[str, str], ...]:
        """Return what and value of what `rig check` shows of the rig's dimensions."""
        return ()

    @classmethod
    def closed_loop(cls, settings: Settings, controller: object) -> ClosedLoop | None:
        """Return the margins of the loop that a controller closes; None: nothing is known of it.

        Parameters
        ----------
        settings, controller : object
            The mechanism's; as the profile has it, and not changed.
        """
        return None

    @classmethod
    def derated(cls, settings: Settings, effort: float, speed: float) -> Settings | None:
        """Return settings for a share of pressure or torque, and of speed; None: nobody knows."""
        return None

    @classmethod
    def slowed(
        cls, settings: Settings, reference: object, controller: Any, period: float, share: float
    ) -> tuple[object, Motion[Reference]] | None:
        """Return who follows a motion with a share of its speed, and that motion.

        None, the default: whoever follows references follows slower ones too, see `slow_down`.
        A mechanism whose laws plan whole motions says how they do it more slowly.

        Parameters
        ----------
        settings, reference, controller, period
            See `plan`.
        share : float
            Of the speed.

        Raises
        ------
        ValueError
            It cannot be done more slowly.
        """
        return None

    @classmethod
    def unfit(cls, settings: Settings) -> str | None:
        """Say why a profile must not move hardware; None: it may."""
        return None

    @classmethod
    @abstractmethod
    def model_of(cls, settings: Settings) -> object:
        """Return what the controllers are told of the mechanics, from the profile's settings."""

    @classmethod
    @abstractmethod
    def plan(
        cls, settings: Settings, reference: object, controller: Any, period: float
    ) -> Motion[Reference]:
        """Turn what an experiment asks for into a motion, and refuse it if it cannot be.

        Parameters
        ----------
        settings, reference : object
            The mechanism's settings, and those of the experiment's reference.
        controller : Controller
            The one that will follow the motion.
        period : float
            The loop's period, s.

        Raises
        ------
        ValueError
            With the instant, the quantity and the bound that make it impossible.
        """

    @classmethod
    def plant_unlike(cls, settings: Settings, reference: object, plant: object) -> tuple[str, ...]:
        """Say in what a plant of these settings is another rig than `plan` counts on; no error."""
        return ()

    @classmethod
    def beyond_drives(
        cls,
        settings: Settings,
        motion: Motion[Reference],
        drives: Mapping[str, AxisBounds],
        period: float,
    ) -> str | None:
        """Say where a motion asks an axis for what its drive refuses; None: nowhere.

        Parameters
        ----------
        settings : object
            The mechanism's settings.
        motion : Motion
            What is to be followed.
        drives : mapping
            Bounds of the drives by the names of their axes.
        period : float
            The loop's period, s.
        """
        return None

    @classmethod
    @abstractmethod
    def approach(cls, start: Reference, end: Reference, duration: float, t: float) -> Reference:
        """Return the reference at `t` on the way from rest at `start` to rest at `end`."""

    @classmethod
    def slow_down(cls, reference: Reference, rate: float, change: float) -> Reference:
        """Return a reference of a motion as it is when the motion is passed more slowly.

        Default: at rest where the reference is. Override it if references have velocities, so
        that the controller hears of no jump in them when an orderly stop begins.

        Parameters
        ----------
        reference : object
            As planned.
        rate : float
            Share of the planned speed, 1 … 0.
        change : float
            Of that share, 1/s.
        """
        return cls.approach(reference, reference, 1.0, 1.0)

    @classmethod
    def pace_between(cls, before: Reference, after: Reference, time: float) -> float:
        """Return how fast one reference goes to another, by any measure: looked at first."""
        return 0.0

    @classmethod
    def longest_freeze(
        cls, settings: Settings, motion: Motion[Reference], period: float
    ) -> Freeze | None:
        """Return for how long setpoints may stay frozen, if that follows from the motion alone.

        Parameters
        ----------
        settings : object
            The mechanism's settings.
        motion : Motion
            What is followed.
        period : float
            The loop's period, s.

        Returns
        -------
        Freeze or None
            None: it takes the plant to find out.
        """
        return None

    @classmethod
    def targets(cls, settings: Settings, controller: object) -> Targets[Reference] | None:
        """Return where the mechanism may be sent by numbers; None: it cannot.

        Parameters
        ----------
        settings : object
            The mechanism's settings.
        controller : Controller
            The one that will follow.
        """
        return None

    def attach(self, controller: Any, motion: Motion[Reference]) -> None:
        """Take the controller and the motion of the run that begins, for what is logged of them."""
        return

    @abstractmethod
    def read(self, now: float) -> State:
        """Assemble one frozen state from the devices' last readings.

        Raises
        ------
        StaleReading
            A reading is older than its limit.
        """

    def recall(self, logged: Mapping[str, float]) -> State:
        """Assemble the state of a cycle from the log, to the bit, in the place of `read`.

        It leaves the mechanism as `read` does. What no column tells, the emergency stop's contact,
        is not watched from then on. Default: refused.

        Parameters
        ----------
        logged : mapping
            The cycle's row by the names of the columns, with the loop's ``clock``, s.
        """
        raise ConfigurationError(f"{type(self).__name__} has no recall(): it cannot be replayed")

    @abstractmethod
    def check(self, state: State, now: float) -> None:
        """Raise if the state is not safe.

        Raises
        ------
        LimitExceeded, EmergencyStop
        """

    def stop_input(self) -> EmergencyStopInput | None:
        """Return the device that reads the emergency stop; None: the rig has no such contact."""
        return None

    def explain(self, error: Exception, state: State) -> Exception:
        """Return a fault with its cause, or as it is; called once, with that cycle's state."""
        return error

    @abstractmethod
    def resting_command(self, state: State) -> Command:
        """Return the command that changes nothing: what the devices hold now."""

    @abstractmethod
    def energised_command(self, state: State) -> Command:
        """Return the command that energises without moving; control starts from it."""

    def balanced_command(self, state: State) -> Command:
        """Return the command from which a stop releases the rig: nothing of it moves anything.

        Default: what the devices hold now.
        """
        return self.resting_command(state)

    def releasing_time(self, balanced: Command) -> float:
        """Return the least time in which an orderly stop may release the rig, s.

        Parameters
        ----------
        balanced : object
            The command from which it is released.
        """
        return self.stopping_time

    @abstractmethod
    def released_command(self) -> Command:
        """Return the command of the released rig, to which a stop leads."""

    @abstractmethod
    def blend(self, start: Command, end: Command, share: float) -> Command:
        """Return the command `share` (0 … 1) of the way from `start` to `end`."""

    @abstractmethod
    def start_limiting(self, state: State) -> None:
        """Make the measured state the one that the rate limit starts from."""

    def has_slipped(self, state: State) -> bool:
        """Return whether something gave way while nothing but brakes or friction held it.

        Asked in each cycle in which the rig is energised, after `check`.
        """
        return False

    def check_command(self, reference: Reference, command: Command) -> None:
        """Raise `SafetyError` if the controller asks for what it never may.

        Called with each command of a controller, before `limit`, which clamps what is only a
        little too much.

        Raises
        ------
        SafetyError
            It names the controller and what it asks for.
        """

    def check_still(self, home: Reference) -> None:
        """Raise `SafetyError` if the rig leaves `home` while it is energised, or `stands`."""

    @abstractmethod
    def limit(self, command: Command) -> Command:
        """Return the command that may be applied; the one choke point."""

    @abstractmethod
    def write(self, applied: Command) -> None:
        """Hand the applied command to the devices as this cycle's setpoints."""

    @abstractmethod
    def row(
        self, state: State, reference: Reference, command: Command, applied: Command
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""

    @abstractmethod
    def reference_of(self, state: State) -> Reference:
        """Return the reference that the rig fulfils as it stands: no motion."""

    @abstractmethod
    def worst_margin(self, state: State, applied: Command, now: float) -> Margin:
        """Return the quantity that is nearest to its limit."""

    @abstractmethod
    def limit_hits(self) -> dict[str, int]:
        """Return how often each limit was hit since the start."""
