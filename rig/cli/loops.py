"""How far the loops of a rig are from instability, as a linear model says."""

import contextlib
import math
import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from rig.cli.tables import Table
from rig.hal.formats import format_quantity

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.plan import Plan
    from rig.hal.closed_loop import ClosedLoop

_OF_LAWS = ("controllers.", "controller=")
"""Settings that choose a law, or say how it works."""


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


def warn_unstable(plan: "Plan", experiment: str, rig: str | None, overrides: Sequence[str]) -> None:
    """Say that a loop is not stable by the linear model, before a simulation of it begins.

    Nobody has looked at a law that was chosen, or whose settings were: others cost no time.

    Parameters
    ----------
    plan : Plan
        That will run.
    experiment, rig : str
        As they were given; None: the experiment's own rig.
    overrides : sequence of str
        What was set otherwise than the files.
    """
    from rig.experiment.loop_margins import loop_of

    if not any(one.startswith(_OF_LAWS) for one in overrides):
        return
    loop = None
    with contextlib.suppress(Exception):  # a law of others may fail here; the run says how
        loop = loop_of(plan.profile, plan.controller)
    if loop is None or loop.stable:
        return
    on = [] if rig is None else ["--rig", rig]
    kept = [one for one in overrides if not one.startswith("rig=")]
    words = ["rig", "check", experiment, *on, *(word for one in kept for word in ("--set", one))]
    click.echo(
        f"warning: the loop of {plan.experiment.controller} is not stable by the linear model "
        f"(phase margin {math.degrees(loop.phase):.3g} deg), and swings unless friction holds it: "
        f"{shlex.join(words)}",
        err=True,
    )


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
    from rig.hal.closed_loop import MOST_SENSITIVE, SENSITIVITY

    bounds = f"at most {SENSITIVITY:g} is wanted, {MOST_SENSITIVE:g} on hardware"
    sensitivity = f"{loop['sensitivity']:.3g} ({bounds})" if loop["stable"] else f"- ({bounds})"
    rows = [
        ("stable without Coulomb friction", _yes(loop["stable"])),
        ("crossover", format_quantity(loop["crossover"], "rad/s")),
        ("phase margin", f"{math.degrees(loop['phase']):.3g} deg"),
        ("bears further dead time of", _bears(loop)),
        ("greatest sensitivity", sensitivity),
    ]
    return Table(f"the loop that {controller} closes, linear", ("what", "value"), rows)


def _yes(stable: bool) -> str:
    return "yes" if stable else "no: friction holds it"


def _bears(loop: dict[str, Any]) -> str:
    return format_quantity(loop["delay"], "s") if loop["stable"] else "nothing: not stable as it is"
