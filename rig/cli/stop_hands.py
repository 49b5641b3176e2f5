"""Simulated hands at a rig: whose world they reach, and how they press an emergency stop."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, Protocol, cast

if TYPE_CHECKING:
    from rig.assembly import Backend, Rig
    from rig.config import Profile
    from rig.hal.world import BreakableWorld

_FAULT: Final = "emergency_stop"
_PRESSES, _RELEASES = 0.5, 1.0
"""When hands do so, s."""


class HasFaults(Protocol):
    """A simulated device."""

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now."""


class StopHands:
    """Hands that press an emergency stop once, and release it.

    Parameters
    ----------
    have : callable
        ``have("emergency_stop", value)`` makes it pressed (1) or released (0).
    """

    def __init__(self, have: Callable[[str, float], None]) -> None:
        self._have = have
        self._left = [(_PRESSES, 1.0), (_RELEASES, 0.0)]

    def act(self, since: float) -> None:
        """Do what is due so many seconds after they were asked."""
        while self._left and since >= self._left[0][0]:
            _, value = self._left.pop(0)
            self._have(_FAULT, value)


def hands_at(made: Rig, on: str | None) -> StopHands | None:
    """Return who presses the stop of a simulated rig; None: nobody, or its own faults do.

    Parameters
    ----------
    made : Rig
        Built, on no hardware.
    on : str, optional
        Other interfaces than the profile's or ``vcan0``.
    """
    from rig.assembly import Backend
    from rig.commissioning.steps.stop import stop_device

    device = stop_device(made)
    if device is None or any(fault.fault == _FAULT for fault in made.profile.simulation.faults):
        return None
    if made.backend is Backend.SIM:
        return StopHands(cast("HasFaults", made.devices[device]).inject)
    if made.backend is Backend.VIRTUAL:
        world = cast("BreakableWorld | None", made.clock.world)  # type: ignore[attr-defined]
    else:
        world = world_on(made.profile, made.backend, on)
    return None if world is None else StopHands(partial(world.inject, device))


def world_on(profile: Profile, backend: Backend, on: str | None) -> BreakableWorld | None:
    """Return the world that another process simulates, if it does."""
    from rig.assembly import Backend, parse_interfaces
    from rig.assembly.simulation_process import reach_world

    if backend is not Backend.VCAN:
        return None
    return reach_world(parse_interfaces(on or backend.value, profile))
