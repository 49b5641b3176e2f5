"""`rig doctor`: what this computer lacks to run a rig on hardware."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import complete_rig, configs_option, json_option, out_option, set_option
from rig.cli.number_option import NumberWithin
from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from rig.doctor.look import Look

_QUICK = 2.0
"""For so long wake-ups are looked at without `--abuse`, s."""
EXIT_UNFIT = 3


@click.command()
@click.argument("rig", required=False, shell_complete=complete_rig)
@click.option(
    "--abuse", "seconds", type=NumberWithin(min=1.0), metavar="SECONDS",
    help="Load processors, disk and memory for so long, and measure wake-ups meanwhile.",
)  # fmt: skip
@click.option(
    "--rate", type=NumberWithin(min=1.0, max=5000.0), help="Of the loop, Hz; default: RIG's."
)
@out_option
@json_option
@set_option
@configs_option
def doctor(
    rig: str | None,
    seconds: float | None,
    rate: float | None,
    out: Path,
    as_json: bool,
    overrides: tuple[str, ...],
    configs: Path | None,
) -> int:
    """Look at this computer, and say with which command each lack is mended.

    With RIG, at the interfaces, ports and cameras that its profile names; without, at those that
    are there. Nothing is sent to the rig. Exit code 3: something is missing without which RIG does
    not run on hardware.
    """
    from rig.assembly import REGISTRY
    from rig.config import load_profile
    from rig.config.models import LoopSettings
    from rig.config.names import find_configs
    from rig.doctor.computer import look_at_computer
    from rig.doctor.look import Fitness
    from rig.doctor.ports import look_at_ports
    from rig.doctor.wakeups import abuse, judge, measure_wakeups
    from rig.doctor.wiring import look_at_wiring

    profile = None
    if rig is not None:
        profile = load_profile(rig, REGISTRY, overrides, find_configs(configs))
    loop = LoopSettings(rate=1000.0) if profile is None else profile.loop
    computer = tuple(look_at_computer(out, loop.priority))
    found = list(computer)
    found += look_at_ports() if profile is None else look_at_wiring(profile)
    at = loop.rate if rate is None else rate
    idle = measure_wakeups(at, _QUICK, loop.priority, loop.cpu, spin=loop.spin)
    found.append(judge(idle, "as it is", computer))
    if seconds is not None:
        with abuse() as load:
            click.echo(f"{seconds:g} s with {load} …", err=True)
            busy = measure_wakeups(at, seconds, loop.priority, loop.cpu, spin=loop.spin)
        found.append(judge(busy, f"loaded for {seconds:g} s", computer))
    _show(found, as_json=as_json)
    return EXIT_UNFIT if any(one.verdict is Fitness.NO for one in found) else 0


def _show(found: list[Look], *, as_json: bool) -> None:
    if as_json:
        print_json({"findings": [one._asdict() for one in found]})
        return
    rows = [(one.what, one.verdict.value, one.found) for one in found]
    print_tables([Table("this computer", ("what", "verdict", "found"), rows)])
    for one in found:
        if one.mend:
            click.echo(f"{one.what}: {one.mend}", err=True)
