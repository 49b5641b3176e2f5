"""Say what will move, how far and under which limits, before hardware does."""

from __future__ import annotations

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
    from rig.assembly import Backend, backend_of, check_fitness
    from rig.commissioning.permission import as_commissioned
    from rig.experiment.fitness import refuse_unfit
    from rig.experiment.permission import check_permitted

    if backend_of(on) is not Backend.HARDWARE:
        return True
    check_permitted(plan, Backend.HARDWARE, on)
    check_fitness(plan.profile)
    plan, said = as_commissioned(plan, Backend.HARDWARE, uncommissioned)
    for sentence in said:
        click.echo(sentence, err=True)
    refuse_unfit(plan, partial(click.echo, err=True))
    for sentence in announcement(plan):
        click.echo(sentence, err=True)
    return confirm(plan.profile.name, yes)


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
