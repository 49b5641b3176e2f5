"""What follows twists that come from outside, one period at a time."""

from abc import ABC, abstractmethod

from controllers.arm.geometry import ArmGeometry
from controllers.arm.on_direction.numbers import Six, TwistNumbers
from controllers.arm.on_direction.pace import next_period
from controllers.arm.types import AT_REST
from controllers.compiled import KernelMemory


class TwistFollower(ABC):
    """The part of a law of the arm that goes on from cycle to cycle with what is asked for.

    Attributes
    ----------
    positions : tuple of float
        Joints that were commanded last, rad.
    """

    positions: Six = AT_REST

    @abstractmethod
    def rest(self, positions: Six) -> None:
        """Begin anew, at rest."""

    @abstractmethod
    def step(self, asked: Six) -> tuple[Six, Six]:
        """Return the joints a period later (rad), and their mean rates on the way (rad/s).

        Parameters
        ----------
        asked : tuple of float
            Twist of the hand, base axes, m/s and rad/s; zero: come to rest.
        """


class OnDirection(TwistFollower):
    """Keeps the hand on the direction that is asked for, and changes how fast it goes there.

    Promises, whatever is asked for: no joint exceeds its rate, its acceleration (second
    differences of the commanded positions) or its range; and once the joints have had the time to
    turn to a new direction, which the accelerations say, the hand is on it through every
    singularity. Near shoulder and wrist it slows down while q1, or q4 and q6, turn. Nearer than
    `FLOOR` (c in m, S5 in rad) it goes straight on, by that much off its line. At the boundary of
    the workspace it stays, or comes back with the elbow on its other side (`through`).

    The time lost is what the joints need: at the wrist q4 turns by up to pi, at the shoulder q1.

    Parameters
    ----------
    geometry : ArmGeometry
        The arm.
    period : float
        s.
    through : bool
        Whether the elbow may go through its singularity.
    rest : int, optional
        The hand goes no faster than that it can come to rest within so many periods.
    """

    def __init__(
        self, geometry: ArmGeometry, period: float, *, through: bool, rest: int | None = None
    ) -> None:
        numbers = TwistNumbers(geometry, period, through=through, rest=rest)
        self._next = KernelMemory(numbers).bind(next_period)
        self.rest(AT_REST)
        self.step(AT_REST)  # the first call is what compiles
        self.rest(AT_REST)

    def rest(self, positions: Six) -> None:
        """See `TwistFollower.rest`."""
        self.positions = positions
        self._rates = self._direction = AT_REST
        self._side, self._share = 1.0, 0.0

    def step(self, asked: Six) -> tuple[Six, Six]:
        """See `TwistFollower.step`."""
        self.positions, self._rates, self._direction, self._side, self._share = self._next(
            self.positions, self._rates, self._direction, self._side, self._share, asked
        )
        return self.positions, self._rates
