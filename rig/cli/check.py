"""`rig check`: whether a profile or an experiment is valid, and what it says."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.file_kinds import asks_of_experiment, experiment_of_same_name, is_experiment
from rig.cli.files_here import ProfileOrExperiment
from rig.cli.names import (
    complete_config,
    configs_option,
    json_option,
    rig_option,
    seed_option,
    set_option,
    with_seed,
)
from rig.cli.on_option import OnBackend
from rig.cli.patience import told_if_long
from rig.cli.tables import print_json, print_tables

if TYPE_CHECKING:
    from rig.config import Profile
    from rig.experiment.plan import Plan


@click.command()
@click.argument(
    "source", metavar="PROFILE|EXPERIMENT", type=ProfileOrExperiment(),
    shell_complete=complete_config,
)  # fmt: skip
@set_option
@seed_option
@rig_option
@configs_option
@click.option(
    "--on",
    type=OnBackend(),
    metavar="INTERFACE|hardware",
    help="Ask these CAN buses, or the profile's own (hardware), who is there, and compare that "
    "with the profile. It only reads: no node is reset or started.",
)
@click.option(
    "--values", is_flag=False, flag_value="", metavar="[PART]",
    help="Show every setting (of those with PART in their name) with its value in SI, and where it "
    "comes from: the file, one that it extends, a calibration, an option, the default.",
)  # fmt: skip
@json_option
def check(
    source: str,
    overrides: tuple[str, ...],
    seed: int | None,
    rig_name: str | None,
    configs: Path | None,
    on: str | None,
    values: str | None,
    as_json: bool,
) -> int:
    """Check a profile or an experiment and show what it says.

    Nothing is opened, unless --on says so. Every error of a file is shown at once, with its line.
    """
    from rig.assembly import check_channels
    from rig.assembly.simulated import check_plant_faults
    from rig.cli.check_hardware import refusals_of, refusals_of_plan, say_untried
    from rig.cli.check_warnings import warnings_of
    from rig.cli.description import (
        describe_experiment,
        describe_frozen,
        describe_profile,
        experiment_tables,
        profile_tables,
    )
    from rig.config.names import find_configs

    profile, plan = load(source, with_seed(overrides, seed), configs, rig_name)
    if values is not None:
        from rig.cli.origins import origins_of, origins_table

        origins = origins_of(profile, values)
        if as_json:
            print_json([origin._asdict() for origin in origins])
        else:
            print_tables([origins_table(origins)])
        return 0
    if on is not None:
        from rig.cli.check_bus import check_buses

        return check_buses(profile, _on_bus(on), as_json=as_json)
    check_channels(profile)
    check_plant_faults(profile)
    described = describe_profile(profile)
    refused = list(refusals_of(profile))
    if plan is None:
        content: dict[str, object] = {"profile": described}
        tables = profile_tables(described)
    else:
        from rig.cli.loops import describe_loop
        from rig.experiment.frozen import longest_freeze

        experiment = describe_experiment(plan)
        experiment["loop"] = describe_loop(plan)
        bound = longest_freeze(plan, partial(click.echo, err=True))
        experiment["frozen"] = describe_frozen(plan, bound)
        refused += refusals_of_plan(plan, bound)
        content = {"experiment": experiment, "profile": described}
        tables = [*experiment_tables(experiment), *profile_tables(described)]
    warnings = warnings_of(profile, find_configs(configs))
    if as_json:
        print_json({**content, "warnings": warnings, "refused_on_hardware": refused})
    else:
        print_tables(tables)
        for warning in warnings:
            click.echo(f"warning: {warning}", err=True)
        told = say_untried(profile) if plan is None else _advice(plan)
        if told is not None and not any(told in sentence for sentence in refused):
            click.echo(told, err=True)
        click.echo(f"{source}: valid", err=True)
        for sentence in refused:
            click.echo(f"hardware would refuse it: {sentence}", err=True)
    return 0


def _advice(plan: Plan) -> str | None:
    from rig.cli.loops import advice

    return advice(plan)


def _on_bus(on: str) -> str:
    if on in ("sim", "virtual"):
        raise click.BadParameter(f"{on} has no bus that could be asked.", param_hint="--on")
    return on


def load(
    source: str, overrides: Sequence[str], configs: Path | None, rig: str | None = None
) -> tuple[Profile, Plan | None]:
    """Load a profile, or an experiment with its profile.

    Raises
    ------
    ConfigurationError
        There is no such file, or it is not valid.
    """
    from rig.config.names import find_configs

    search = find_configs(configs)
    other = experiment_of_same_name(source, search)
    meant = other is not None and (rig is not None or asks_of_experiment(overrides))
    if meant or is_experiment(source, search):
        from rig.experiment.plan import load_plan

        with told_if_long("planning the motion"):
            plan = load_plan(source, overrides, rig=rig, configs=configs)
        return plan.profile, plan
    if rig is not None:
        raise click.UsageError(f"{source} is a rig; --rig goes with an experiment")
    if other is not None:
        click.echo(f"{source} is a rig; an experiment of that name is {other}", err=True)
    from rig.assembly import REGISTRY, check_profile, with_what_else
    from rig.config import ProfileError, load_profile

    try:
        profile = load_profile(source, REGISTRY, overrides, search)
    except ProfileError as error:
        raise with_what_else(error) from error
    check_profile(profile)
    _check_laws(profile)
    return profile, None


def _check_laws(profile: Profile) -> None:
    """Refuse a rig that leaves none of its laws any room, as whatever is run on it would be.

    Raises
    ------
    MotionRefused
        What the first of them says.
    """
    from rig.assembly import make_law
    from rig.config.located import places_named
    from rig.hal import MotionRefused

    refused: list[str] = []
    for name in profile.controllers:
        try:
            make_law(profile, name)
        except MotionRefused as error:
            refused.append(str(error))
        else:
            return  # which law it is, an experiment says; `rig check EXPERIMENT` checks that one
    for said in refused[:1]:
        told = places_named(said, {}, profile.places, profile.mechanism)
        raise MotionRefused(f"{profile.name}: {told}")
