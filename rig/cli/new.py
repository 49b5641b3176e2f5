"""`rig new`: files to begin with, which run at once in simulation."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, cast

import click

from rig.cli.names import OneOf, configs_option, json_option
from rig.cli.tables import print_json
from rig.terminals import is_terminal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rig.hal.drawn_profile import DrawnProfile
    from rig.scaffolding.packages import PackageKind

_PACKAGES = ("controller", "driver", "mechanism")
_KINDS = ("experiment", "rig", *_PACKAGES)


@click.command()
@click.argument("kind", type=OneOf(_KINDS))
@click.argument("name")
@click.option("--rig", help="Of an experiment: whose it is. Default: cylinder.")
@click.option("--like", metavar="NAME", help="The experiment or rig to begin with.")
@click.option("--urdf", metavar="FILE", help="Of a rig: the arm that a URDF describes.")
@click.option("--dh", metavar="FILE", help="Of a rig: the arm of Denavit-Hartenberg parameters.")
@click.option(
    "--scan",
    metavar="INTERFACES",
    help="Of a rig: with what answers there, e.g. can0 or /dev/ttyUSB0.",
)
@click.option(
    "--eds", metavar="FILE", multiple=True,
    help="With --scan: the EDS of a device that answers, whose objects and mapping are taken.",
)  # fmt: skip
@click.option("--tip", metavar="LINK", help="With --urdf: the link that is the tool.")
@configs_option
@json_option
def new(
    kind: str,
    name: str,
    rig: str | None,
    like: str | None,
    urdf: str | None,
    dh: str | None,
    scan: str | None,
    eds: tuple[str, ...],
    tip: str | None,
    configs: Path | None,
    as_json: bool,
) -> int:
    """Write files to begin with, under NAME: an experiment, rig, controller, driver or mechanism.

    An experiment and a rig are one commented file each. A controller (for the pair of cylinders),
    a driver (a sensor on an analogue input, which is logged) and a mechanism (an axis on a servo
    drive, with its physics) are packages with a test, a profile and an experiment that runs at
    once; what another package has needs no change of this program. A rig from --urdf or --dh has
    the dimensions, ranges and speeds of a six-joint arm with a spherical wrist; what else it is
    made of is refused with the reason. A rig from --scan has the node numbers and identities of
    whoever answers, for the devices of --like, on CAN and on serial chains, and this computer's
    cameras; with --eds what those devices map. Who is like none of them is written as comments.
    Nothing is changed on the buses.
    """
    from rig.config.names import find_configs
    from rig.hal import ConfigurationError
    from rig.hal.files import reason_unwritten
    from rig.scaffolding.files import experiment_text, profile_text
    from rig.scaffolding.known_names import refuse_known_file, refuse_known_part
    from rig.scaffolding.names import refuse_taken, spell
    from rig.scaffolding.packages import first_experiment, package_files, profile_of, write_files
    from rig.whole_file import write_whole

    spell(name)
    drawn = [(form, file) for form, file in (("urdf", urdf), ("dh", dh)) if file is not None]
    other = rig is not None or like is not None
    if drawn and (kind != "rig" or other or len(drawn) > 1):
        raise click.UsageError("a rig is made from one of --urdf, --dh, --rig and --like")
    if scan is not None and (kind != "rig" or drawn):
        raise click.UsageError("--scan is for a rig, with --like or --rig")
    if eds and scan is None:
        raise click.UsageError("--eds goes with --scan, which says whose file it is")
    if tip is not None and urdf is None:
        raise click.UsageError("--tip names a link of --urdf")
    notes: tuple[str, ...] = ()
    if kind not in _PACKAGES and not (drawn or scan or other or as_json):
        rig, like = _asked(kind)
    if kind in _PACKAGES:
        if rig is not None or like is not None:
            raise click.UsageError("--rig and --like are for experiments and rigs")
        package = cast("PackageKind", kind)
        first = first_experiment(package, name)
        refuse_known_part(name, (profile_of(name), first), find_configs(configs))
        refuse_taken(name)
        written = Path(name)
        write_files(written, package_files(package, name))
        profile = written / "configs" / "rigs" / f"{profile_of(name)}.yaml"
        if kind == "controller":
            notes = (f"another rig has {name} with the `additions` and `controllers` of {profile}",)
        if kind == "driver":
            notes = (f"simulated, it shows a wire's tension: `measures` in {profile} chooses",)
        following = [
            f"pip install -e './{name}[test]'",
            f"cd {name} && rig run {first} --on sim",
            f"cd {name} && pytest tests",
        ]
    else:
        file = written = Path(f"{name}.yaml")
        if os.path.lexists(file):  # also a link to nowhere: what is written must not follow it
            raise ConfigurationError(
                f"{file} is there already; nothing was written: take another name"
            )
        search = find_configs(configs)
        refuse_known_file(name, search)
        if kind == "experiment":
            text = experiment_text(name, rig, search, like)
            following = [f"rig check {file}", f"rig run {file} --on sim"]
        elif drawn:
            text, notes = _drawn(name, *drawn[0], tip)
            following = [f"rig check {file}", f"rig run arm-tour --on sim --rig {file}"]
        elif scan is not None:
            text, notes = _scanned(name, like or rig or "cylinder", scan, search, eds)
            following = [f"rig check {file} --on {scan}", f"rig status {file}"]
        else:
            text = profile_text(name, like or rig or "cylinder", search)
            following = [f"rig check {file}", f"rig check {file} --values"]
        try:
            write_whole(file, text)
        except OSError as error:
            raise ConfigurationError(
                f"cannot write {file}: {reason_unwritten(file, error)}"
            ) from error
    if as_json:
        print_json(
            {"kind": kind, "name": name, "written": written, "notes": notes, "next": following}
        )
        return 0
    for note in notes:
        click.echo(f"note: {note}", err=True)
    click.echo(f"{kind} {name} is written; next:", err=True)
    for line in following:
        click.echo(f"  {line}", err=True)
    return 0


def _asked(kind: str) -> tuple[str | None, str | None]:
    """Return --rig and --like as somebody at a terminal answers; a script is not asked."""
    if not (is_terminal(sys.stdin) and is_terminal(sys.stderr)):
        return None, None
    what = "Like which rig (`rig list rigs`)" if kind == "rig" else "Of which rig (`rig list rigs`)"
    rig = click.prompt(what, default="cylinder", err=True)
    if kind == "rig":
        return rig, None
    first = "its first"
    like = click.prompt("Like which of its experiments", default=first, err=True)
    return rig, None if like == first else like


def _drawn(name: str, form: str, file: str, tip: str | None) -> DrawnProfile:
    """Return the profile that a description comes to."""
    from rig.assembly import REGISTRY

    return REGISTRY.drawing(form)(name, Path(file), tip)


def _scanned(
    name: str, like: str, on: str, search: Sequence[Path], eds: Sequence[str]
) -> DrawnProfile:
    """Return the profile of whoever answers."""
    from rig.scaffolding.scanned import scanned_profile

    if on in ("sim", "virtual"):
        raise click.BadParameter(f"{on} has no bus that could be asked.", param_hint="--scan")
    return scanned_profile(name, like, on, search, [Path(file) for file in eds])
