"""What hardware would refuse of a profile or an experiment that is valid."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.frozen import Bound
    from rig.experiment.plan import Plan


def refusals_of(profile: Profile) -> Iterator[str]:
    """Yield why hardware would not run a profile as it is now, each with its mend.

    Parameters
    ----------
    profile : Profile
        Checked.
    """
    from rig.assembly import Backend, check_fitness
    from rig.commissioning.permission import verdict_of
    from rig.config.calibration_state import calibration_states
    from rig.experiment.fault_latch import FaultLatch

    yield from _said_by(FaultLatch.of(profile).check)
    for state in calibration_states(profile, datetime.now(UTC).date(), on_hardware=True):
        if state.problems:
            yield f"{state.name}: {state.sentence}"
    yield from _said_by(lambda: check_fitness(profile))
    if trouble := verdict_of(profile, Backend.HARDWARE).trouble:
        yield trouble


def refusals_of_plan(plan: Plan, bound: Bound, *, heed_commissioning: bool = True) -> Iterator[str]:
    """Yield why hardware would not run an experiment whose profile it takes, each with its mend.

    Parameters
    ----------
    plan : Plan
        Checked.
    bound : Freeze or NoBound or Unfollowed
        For how long its setpoints may stay as they are.
    heed_commissioning : bool
        Nobody has said why it moves though it is not commissioned.
    """
    from rig.assembly import Backend
    from rig.commissioning.permission import as_commissioned, verdict_of
    from rig.experiment.frozen import refuse_slow_devices
    from rig.experiment.loop_margins import refuse_small_margin

    if heed_commissioning and not verdict_of(plan.profile, Backend.HARDWARE).trouble:
        yield from _said_by(lambda: as_commissioned(plan, Backend.HARDWARE))
    yield from _said_by(lambda: refuse_slow_devices(plan, _unheard, bound))
    yield from _said_by(lambda: refuse_small_margin(plan, _unheard))


def say_untried(profile: Profile) -> str | None:
    """Say what of a profile an experiment alone can tell; None: nothing of it acts by itself."""
    from rig.experiment.slowest import slowest_device
    from rig.hal.formats import format_quantity

    slowest = slowest_device(profile)
    if slowest is None:
        return None
    return (
        f"if the program dies, {slowest.device} keeps its setpoints for "
        f"{format_quantity(slowest.after, 's')}: whether a motion bears that, and with it whether "
        "hardware runs it, is told by: rig check EXPERIMENT --rig "
        f"{shlex.quote(profile.argument)}"
    )


def _said_by(check: Callable[[], object]) -> Iterator[str]:
    """Yield what a check refuses, if it does."""
    from rig.hal import RigError

    try:
        check()
    except RigError as error:
        yield str(error)


def _unheard(sentence: str) -> None:
    """Leave out what a profile accepts: it is told where it runs."""
