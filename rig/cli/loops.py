"""How far the loops of a rig are from instability, as a linear model says."""

import math
from typing import TYPE_CHECKING, Any

from rig.cli.tables import Table
from rig.config.formats import format_quantity

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.plan import Plan
    from rig.hal.mechanism import ClosedLoop


def describe_loop(plan: "Plan") -> dict[str, Any] | None:
    """Return the margins of the loop that the controller closes, in SI; None: nothing is known."""
    loop = _loop_of(plan.profile, plan.controller)
    return None if loop is None else loop._asdict()


def advice(plan: "Plan") -> str | None:
    """Return what to do about a loop that is too near to instability; None: nothing."""
    loop = _loop_of(plan.profile, plan.controller)
    if loop is None or loop.is_robust:
        return None
    return _advice(plan.profile, plan.experiment.controller, loop)


def loops_of(profile: "Profile") -> tuple[list[Table], list[str]]:
    """Return a table of the loops that a profile's controllers close, and what to do about them."""
    from rig.assembly import make_controller
    from rig.hal import MotionRefused

    rows, sentences = [], []
    for name in profile.controllers:
        try:
            loop = _loop_of(profile, make_controller(profile, name))
        except MotionRefused:  # a package that it needs is not installed
            continue
        if loop is None:
            continue
        phase = f"{math.degrees(loop.phase):.3g} deg"
        rows.append((name, _yes(loop.stable), format_quantity(loop.crossover, "rad/s"), phase,
                     _bears(loop._asdict()), f"{loop.sensitivity:.3g}"))  # fmt: skip
        if not loop.is_robust:
            sentences.append(_advice(profile, name, loop))
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
        ("greatest sensitivity", f"{loop['sensitivity']:.3g}"),
    ]
    return Table(f"the loop that {controller} closes, linear", ("what", "value"), rows)


def _yes(stable: bool) -> str:
    return "yes" if stable else "no: friction holds it"


def _bears(loop: dict[str, Any]) -> str:
    return format_quantity(loop["delay"], "s") if loop["stable"] else "nothing: not stable as it is"


def _advice(profile: "Profile", controller: str, loop: "ClosedLoop") -> str:
    from controllers.base import Law
    from rig.assembly import REGISTRY
    from rig.config.named_settings import controller_key

    how = f"has a sensitivity of {loop.sensitivity:.2g}, above 2" if loop.stable else (
        "is stable by friction only"
    )  # fmt: skip
    said = f"the loop of {controller} {how}"
    law = REGISTRY.load("controller", controller_key(REGISTRY, profile.mechanism, controller))
    tunable = isinstance(law, type) and issubclass(law, Law) and law.tunables
    if REGISTRY.bench(profile.mechanism) is None or not tunable:
        return said
    tune = f"`rig tune {profile.name} --controller {controller}`"
    return f"{said}: {tune} looks for gains that bear this rig"


def _loop_of(profile: "Profile", controller: object) -> "ClosedLoop | None":
    from rig.assembly import REGISTRY
    from rig.assembly.contract_check import ask
    from rig.hal import Mechanism
    from rig.hal.mechanism import ClosedLoop

    view = REGISTRY.load("mechanism", profile.mechanism)
    what = f"the mechanism {profile.mechanism}"
    loop = ask(what, Mechanism, "closed_loop", view, profile.mechanism_settings, controller)
    return loop if isinstance(loop, ClosedLoop) else None
