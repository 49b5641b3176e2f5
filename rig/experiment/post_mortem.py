"""Whose value made the program fail, when it was no exception of theirs.

A law, a mechanism or a driver of another package may return what only our code then stumbles over.
Looking at it each cycle would cost; it is looked at once, when a run has failed.
"""

import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, get_type_hints

from rig.assembly import Rig
from rig.experiment.plan import Plan
from rig.hal import Device, Mechanism
from rig.hal.devices import LinearEncoder, MarkerCamera, PressureRegulator, ServoBus
from rig.hal.fits import OWN, fits, is_number, is_ours, plain, shown, where
from rig.hal.offers import lacking
from rig.runtime.phases import UNANSWERED, Phase, Phases

_READ = {
    PressureRegulator: ("pressure", "safe_pressure"),
    LinearEncoder: ("position", "velocity"),
    MarkerCamera: ("markers",),
    ServoBus: ("positions", "velocities"),
}
"""What is read of a device, by what it can do."""


Run = Phases[Any, Any, Any]
"""The way of a run, whatever its mechanism."""


class _Asked(NamedTuple):
    """An answer of somebody's code, and what it should have been."""

    whose: object
    method: str
    value: object
    wanted: str

    def __str__(self) -> str:
        place = f"{where(type(self.whose))}.{self.method}"
        return f"{place} returned {shown(self.value)}, and no {self.wanted}"


def whose_value(rig: Rig, plan: Plan, run: Run | None, error: BaseException) -> str | None:
    """Return which code of another package returned what the contract does not permit.

    Parameters
    ----------
    rig, plan : Rig, Plan
        What was run.
    run : Phases, optional
        How far the loop came; None: not to its first cycle.
    error : Exception
        What ended it.

    Returns
    -------
    str or None
        A sentence; None if all that can be asked again is as it must be.
    """
    plant = getattr(rig.truth, "__self__", None)
    try:
        for asked in _answers(rig, plan, run):
            if not is_ours(type(asked.whose)):
                return str(asked)
            if plant is not None and not is_ours(type(plant)):
                return f"{where(type(plant))} is the plant, and {asked}"
    except Exception:  # as the one that ended the run, which says more
        return None
    if plant is not None and not is_ours(type(plant)) and _is_in_simulation(error):
        return f"{where(type(plant))} told a simulated device what it cannot take: {error}"
    return None


def _is_in_simulation(error: BaseException) -> bool:
    """Return whether a simulated device raised an error."""
    modules = [
        str(frame.f_globals.get("__name__")) for frame, _ in traceback.walk_tb(error.__traceback__)
    ]
    ours = [module for module in modules if module.partition(".")[0] in OWN]
    return bool(ours) and ours[-1].startswith("drivers.sim.")


def _answers(rig: Rig, plan: Plan, run: Run | None) -> Iterator[_Asked]:
    for device in rig.devices.values():
        yield from _of_device(device, rig.clock.now())
    if rig.truth_columns:
        yield from _of_numbers(
            getattr(rig.truth, "__self__", None), "truth", len(rig.truth_columns), rig.truth
        )
    if run is None or run.state is None:
        return
    mechanism, state = rig.mechanism, run.state
    commands = {
        "resting_command": mechanism.resting_command(state),
        "energised_command": mechanism.energised_command(state),
        "balanced_command": mechanism.balanced_command(state),
        "released_command": mechanism.released_command(),
    }
    usual = _usual(tuple(commands.values()))
    for method, command in commands.items():
        yield from _unlike(mechanism, method, command, usual)
    here = mechanism.reference_of(state)
    if run.phase is Phase.RUN:
        yield from _unlike(plan.motion, "at", run.reference, here)
    elif run.is_controlling:  # on its way to the motion's start, or from where it braked
        start = plan.motion.at(0.0)
        yield from _unlike(plan.motion, "at", start, here)
        between = mechanism.approach(here, start, 1.0, 0.5)
        yield from _unlike(mechanism, "approach", between, here)
    if run.is_controlling and run.answer is not UNANSWERED:  # else its first call has raised
        yield from _unlike(plan.controller, "update", run.answer, usual)
    if run.command is None or run.reference is None:
        return
    applied = mechanism.limit(run.command)
    yield from _unlike(mechanism, "limit", applied, usual)
    yield from _of_numbers(
        mechanism,
        "row",
        len(mechanism.columns),
        lambda: mechanism.row(state, run.reference, run.command, applied),
    )
    yield from _unfit(
        mechanism, Mechanism, "worst_margin", mechanism.worst_margin(state, applied, state.t)
    )
    for method in ("limit_hits", "pose_held"):
        yield from _unfit(mechanism, Mechanism, method, getattr(mechanism, method)())


def _of_device(device: Device, now: float) -> Iterator[_Asked]:
    if device.log_columns:
        yield from _of_numbers(device, "log_values", len(device.log_columns), device.log_values)
    yield from _unfit(device, Device, "doubt", device.doubt(now))
    for kind, methods in _READ.items():
        if not lacking(device, kind):
            for method in methods:
                yield from _unfit(device, kind, method, getattr(device, method)())


def _of_numbers(
    whose: object, method: str, count: int, tell: Callable[[], Sequence[object]]
) -> Iterator[_Asked]:
    """Yield what is no tuple of so many numbers."""
    found = tell()
    try:
        good = len(found) == count and all(map(is_number, found))
    except TypeError:
        good = False
    if not good:
        yield _Asked(whose, method, found, f"tuple of {count} numbers")


def _unfit(whose: object, protocol: type, method: str, found: object) -> Iterator[_Asked]:
    """Yield what is not of the type that a protocol says."""
    hint = get_type_hints(getattr(protocol, method))["return"]
    if not fits(found, hint):
        yield _Asked(whose, method, found, plain(hint))


def _usual(commands: Sequence[object]) -> object:
    """Return the command that most others are like: any one of them may be the wrong one."""

    def fellows(one: object) -> int:
        return sum(_is_like(other, one) and _is_like(one, other) for other in commands)

    return max(commands, key=fellows)


def _unlike(whose: object, method: str, found: object, like: object) -> Iterator[_Asked]:
    """Yield what is not as the mechanism's own value of its kind is."""
    if not _is_like(found, like):
        yield _Asked(whose, method, found, f"{type(like).__name__} as {shown(like)}")


def _is_like(found: object, like: object) -> bool:
    """Return whether a value has the type of another, down to the numbers that it holds."""
    if is_number(like):
        return is_number(found)
    if isinstance(like, tuple):
        if not isinstance(found, tuple | type(like)) or len(found) != len(like):
            return False
        if hasattr(like, "_fields") and not isinstance(found, type(like)):
            return False
        return all(map(_is_like, found, like))
    return True
