"""What is valid, and yet is not what somebody wants who is going to run it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rig.config import Profile

_MOST_UNITLESS = 12
"""Numbers without a unit that are told one by one."""


def tell_warnings(
    profile: Profile, search: Sequence[Path] | None = None, told: set[str] | None = None
) -> None:
    """Say what `rig check` warns of, before hardware moves by it.

    Parameters
    ----------
    profile : Profile
        Checked.
    search : sequence of Path, optional
        Folders of configurations; default: the profile's own, then the usual ones.
    told : set of str, optional
        What this command has said already, which is not said again; it gets what is said here.
    """
    from rig.commissioning.permission import configs_of

    told = set() if told is None else told
    for sentence in warnings_of(profile, configs_of(profile) if search is None else search):
        if sentence not in told:
            click.echo(f"warning: {sentence}", err=True)
            told.add(sentence)


def warnings_of(profile: Profile, search: Sequence[Path]) -> list[str]:
    """Return what `rig check` warns of.

    Parameters
    ----------
    profile : Profile
        Checked.
    search : sequence of Path
        The folders of configurations.
    """
    from rig.cli.inherited import inherited_sentences
    from rig.cli.plant_remarks import plant_remarks
    from rig.cli.valve_life import valve_life_remarks
    from rig.config.calibration_state import sentences_of_bases
    from rig.config.records import sentences_of_records

    inherited = inherited_sentences(profile, search)
    elsewhere = [*sentences_of_bases(profile), *sentences_of_records(profile, search)]
    strange = [*_strange_units(profile), *_unitless(profile.unitless)]
    plant = plant_remarks(profile)
    lacking, valves = _of_simulation(profile), valve_life_remarks(profile)
    return [*_of_broken_parts(profile), *inherited, *plant, *elsewhere, *strange, *valves, *lacking]


def _of_simulation(profile: Profile) -> Iterator[str]:
    """Say what the plant needs and is not there; hardware runs without."""
    from rig.assembly.simulated import make_plant
    from rig.hal import ConfigurationError
    from rig.installation import missing_package, need

    try:
        need("mujoco")  # first: to make a plant takes its time
    except ModuleNotFoundError:
        try:
            if profile.plant is not None:
                make_plant(profile)
        except (ConfigurationError, ModuleNotFoundError) as error:
            yield f"it cannot be simulated: {missing_package(error) or error}"


def _unitless(said: Sequence[str]) -> Sequence[str]:
    """Return the sentences on numbers without a unit; a file that a program wrote has one."""
    if len(said) <= _MOST_UNITLESS:
        return said
    return [f"{len(said)} numbers have no unit and are read in SI, as programs write them"]


def _of_broken_parts(profile: Profile) -> Iterator[str]:
    from rig.assembly import REGISTRY
    from rig.hal.formats import format_quantity

    view = REGISTRY.load("mechanism", profile.mechanism)
    for of in view.expected_of(profile.mechanism_settings):
        if of.warning:
            yield f"{of.name} {format_quantity(of.value, of.unit)}: {of.warning}"


def _strange_units(profile: Profile) -> Iterator[str]:
    """Say which logged quantities of devices are in units that nobody can convert."""
    from rig.assembly import check_profile
    from rig.assembly.channels import where_said
    from rig.config.dump import plain_of
    from rig.config.located import places_named
    from rig.config.quantities import UnitError, parse_unit

    devices = plain_of(profile)["devices"]
    for column in check_profile(profile):
        try:
            parse_unit(column.unit)
        except UnitError:
            owners = _owners(column.name, list(profile.devices))
            said = [
                ".".join(("devices", name, *where_said(column.unit, devices[name])))
                for name in owners
                if isinstance(devices, dict)
            ]
            yield places_named(
                f"{' or '.join(said) or profile.mechanism}: {column.name} is in {column.unit}, "
                "which is no unit that this program knows: figures, reports and exported files "
                "show the word as it is, and no bound in another unit can be held against it",
                profile.places,
            )


def _owners(column: str, devices: Sequence[str]) -> list[str]:
    """Return the device that a column belongs to by its name; none: it is the mechanism's."""
    return [name for name in devices if column.startswith(f"device.{name.replace('-', '_')}_")][-1:]
