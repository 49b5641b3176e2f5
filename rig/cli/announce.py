"""Say what will move, how far and under which limits, before hardware does."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

import click

from rig.cli.confirm import confirm

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.plan import Plan

_PREFIX = "reference."


def may_move(plan: Plan, on: str, yes: str | None, uncommissioned: str | None = None) -> bool:
    """Say what an experiment will move on hardware; return whether the operator wants it to.

    Raises
    ------
    DeviceError
        It is refused whatever the operator says.
    """
    from rig.assembly import Backend, backend_of
    from rig.cli.check_warnings import tell_warnings
    from rig.hal import RigError

    if backend_of(on) is not Backend.HARDWARE:
        return True
    asked = plan.profile
    try:
        plan = _permitted(plan, on, uncommissioned)
    except RigError as error:
        for reason in _other_reasons(plan, str(error), uncommissioned):
            error.add_note(f"refused as well: {reason}")
        raise
    for sentence in announcement(plan):
        click.echo(sentence, err=True)
    tell_warnings(asked)  # of all that it may do, as `rig check` does, commissioned or not
    return confirm(plan.profile.name, yes)


def _permitted(plan: Plan, on: str, uncommissioned: str | None) -> Plan:
    """Return a plan as hardware may carry it out; what there is to say of it is said.

    Raises
    ------
    RigError
        The first reason why it must not.
    """
    from rig.assembly import Backend, check_fitness
    from rig.commissioning.permission import as_commissioned
    from rig.experiment.fitness import refuse_unfit
    from rig.experiment.permission import check_permitted

    check_permitted(plan, Backend.HARDWARE, on)
    check_fitness(plan.profile)
    plan, said = as_commissioned(plan, Backend.HARDWARE, uncommissioned)
    for sentence in said:
        click.echo(sentence, err=True)
    refuse_unfit(plan, partial(click.echo, err=True))
    return plan


def _other_reasons(plan: Plan, first: str, uncommissioned: str | None) -> Iterator[str]:
    """Yield why hardware would refuse a plan besides the reason that was met first."""
    from rig.cli.check_hardware import refusals_of, refusals_of_plan
    from rig.experiment.frozen import longest_freeze

    yield from (reason for reason in refusals_of(plan.profile) if reason != first)
    wanted: list[str] = []
    with contextlib.suppress(Exception):  # nothing that is told besides may hide the first reason
        bound = longest_freeze(plan, partial(click.echo, err=True))
        wanted += refusals_of_plan(plan, bound, heed_commissioning=uncommissioned is None)
    yield from (reason for reason in wanted if reason != first)


def announcement(plan: Plan) -> Iterator[str]:
    """Yield what will move, how far, and its limits."""
    from rig.experiment.extent import extent_of
    from rig.hal.formats import format_quantity

    experiment, rig = plan.experiment, plan.profile.name
    yield (
        f"{experiment.name} moves {rig} for {plan.motion.foreseen.duration:.1f} s, after an "
        f"approach of {experiment.approach:.1f} s from where it stands:"
    )
    try:
        extents = extent_of(plan)
    except Exception as error:  # a rig's computer may lack what simulation takes
        extents = []
        yield f"  how far cannot be told: {error}"
    for column, low, high in extents:
        first, last = (format_quantity(value, column.unit) for value in (low, high))
        yield f"  {column.name.removeprefix(_PREFIX)}: {first} … {last}"
    yield from limits(plan.profile)


def limits(profile: Profile) -> Iterator[str]:
    """Yield a rig's limits."""
    from rig.cli.description import describe_profile, profile_tables

    described = profile_tables(describe_profile(profile))
    (table,) = [table for table in described if table.title == "limits"]
    yield f"  limits: {'; '.join(' '.join(row) for row in table.rows)}"
