"""The readings of joints that each have a drive of their own."""

from collections.abc import Mapping
from typing import Generic, Protocol, TypeVar

from rig.hal import Reading, ServoBus, Vector

Value = TypeVar("Value", int, float)


def joined(each: Mapping[str, Mapping[str, Value]]) -> dict[str, Value]:
    """Return what each joint says as one mapping, with the joint's name before its own."""
    return {f"{joint} {key}": value for joint, its in each.items() for key, value in its.items()}


class AxisReading(Protocol):
    """The last reading of one joint."""

    @property
    def position(self) -> float:
        """Rad."""

    @property
    def velocity(self) -> float:
        """By the drive's own account, rad/s."""

    @property
    def torque(self) -> float:
        """At the joint, N m; 0 where it is not known."""

    @property
    def time(self) -> float:
        """When it was taken, s."""


Axis = TypeVar("Axis", bound=AxisReading, covariant=True)


class AxisReadings(ServoBus, Generic[Axis]):
    """Base of the servo devices whose joints keep their own readings."""

    drives: tuple[Axis, ...]

    @property
    def oldest_axis(self) -> str:
        """The joint that was heard of before every other; empty: there is none."""
        times = [drive.time for drive in self.drives]
        oldest = min(times)
        return self.axis_names[times.index(oldest)] if times.count(oldest) == 1 else ""

    def positions(self) -> Reading[Vector]:
        """Return the joint positions, rad, shape (n,); as old as the oldest of them."""
        return self._reading([drive.position for drive in self.drives])

    def velocities(self) -> Reading[Vector]:
        """Return the drives' own joint velocities, rad/s, shape (n,)."""
        return self._reading([drive.velocity for drive in self.drives])

    def torques(self) -> Reading[Vector]:
        """Return the drives' torques at the joints, N m, shape (n,); 0 where none is known."""
        return self._reading([drive.torque for drive in self.drives])

    def _reading(self, values: list[float]) -> Reading[Vector]:
        return Reading(tuple(values), min([drive.time for drive in self.drives]))
