"""How far the loops of a rig are from instability, as a linear model says."""

import math
from typing import TYPE_CHECKING, Any

from rig.cli.tables import Table
from rig.hal.formats import format_quantity

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.plan import Plan
    from rig.hal.closed_loop import ClosedLoop


def describe_loop(plan: "Plan") -> dict[str, Any] | None:
    """Return the margins of the loop that the controller closes, in SI; None: nothing is known."""
    from rig.experiment.loop_margins import loop_of

    loop = loop_of(plan.profile, plan.controller)
    return None if loop is None else loop._asdict()


def advice(plan: "Plan") -> str | None:
    """Return what to do about a loop that is too near to instability; None: nothing."""
    from rig.experiment.loop_margins import advice_on, loop_of

    loop = loop_of(plan.profile, plan.controller)
    return None if loop is None else advice_on(plan.profile, plan.experiment.controller, loop)


def known_loops(profile: "Profile") -> "dict[str, ClosedLoop]":
    """Return the loops that a profile's controllers close, by the controller."""
    from rig.assembly import make_law
    from rig.experiment.loop_margins import loop_of
    from rig.hal import MotionRefused

    loops = {}
    for name in profile.controllers:
        try:
            loop = loop_of(profile, make_law(profile, name))
        except MotionRefused:  # a package that it needs is not installed
            continue
        if loop is not None:
            loops[name] = loop
    return loops


def loops_of(profile: "Profile", loops: "dict[str, ClosedLoop]") -> tuple[list[Table], list[str]]:
    """Return a table of the loops of a profile, and what to do about them."""
    from rig.experiment.loop_margins import advice_on

    rows, sentences = [], []
    for name, loop in loops.items():
        phase = f"{math.degrees(loop.phase):.3g} deg"
        sensitivity = f"{loop.sensitivity:.3g}" if loop.stable else "-"
        rows.append((name, _yes(loop.stable), format_quantity(loop.crossover, "rad/s"), phase,
                     _bears(loop._asdict()), sensitivity))  # fmt: skip
        if (sentence := advice_on(profile, name, loop)) is not None:
            sentences.append(sentence)
    head = (
        "controller",
        "stable",
        "crossover",
        "phase margin",
        "bears more dead time",
        "sensitivity",
    )
    return ([Table(f"loops of {profile.name}, linear", head, rows)] if rows else []), sentences


def loop_table(controller: str, loop: dict[str, Any]) -> Table:
    """Return what `describe_loop` says as a table."""
    rows = [
        ("stable without Coulomb friction", _yes(loop["stable"])),
        ("crossover", format_quantity(loop["crossover"], "rad/s")),
        ("phase margin", f"{math.degrees(loop['phase']):.3g} deg"),
        ("bears further dead time of", _bears(loop)),
        ("greatest sensitivity", f"{loop['sensitivity']:.3g}" if loop["stable"] else "-"),
    ]
    return Table(f"the loop that {controller} closes, linear", ("what", "value"), rows)


def _yes(stable: bool) -> str:
    return "yes" if stable else "no: friction holds it"


def _bears(loop: dict[str, Any]) -> str:
    return format_quantity(loop["delay"], "s") if loop["stable"] else "nothing: not stable as it is"
