"""`rig reset`: an operator says that the cause of a fault was found and mended."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import complete_rig, configs_option, json_option, set_option, yes_option
from rig.cli.on_option import OnBackend
from rig.cli.tables import print_json

if TYPE_CHECKING:
    from rig.assembly import Rig

_LOOK_EVERY = 0.02
"""s; nobody presses and releases a mushroom button in less than twice of it."""


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--on", "on", type=OnBackend(), default="hardware", show_default=True,
    help="Where the emergency stop is read, as for `rig run`.",
)  # fmt: skip
@click.option(
    "--wait", type=click.FloatRange(min=0), default=60.0, show_default=True, metavar="SECONDS",
    help="For how long at most the emergency stop is waited for.",
)  # fmt: skip
@yes_option
@set_option
@configs_option
@json_option
def reset(
    rig: str,
    on: str,
    wait: float,
    yes: str | None,
    overrides: tuple[str, ...],
    configs: Path | None,
    as_json: bool,
) -> int:
    """Reset the latched fault of RIG, which keeps it from being run on hardware.

    Whoever resets stands beside the rig: its emergency stop is to be pressed and released. A rig
    without a contact asks for its name.
    """
    from rig.assembly import REGISTRY, Backend, backend_of, build_rig
    from rig.config import load_profile
    from rig.config.names import find_configs
    from rig.experiment.fault_latch import FaultLatch

    if backend_of(on) is not Backend.HARDWARE:
        raise click.BadParameter("only hardware has a fault that is latched.", param_hint="--on")
    profile = load_profile(rig, REGISTRY, overrides, find_configs(configs))
    latch = FaultLatch(profile.name)
    reason = latch.reason()
    code = 0
    if reason is None:
        click.echo(f"{profile.name} has no latched fault", err=True)
    else:
        click.echo(f"{profile.name} is latched: {reason}", err=True)
        made = build_rig(profile, Backend.HARDWARE, None if on in list(Backend) else on)
        code = _ask(made, profile.name, yes, wait)
        if code == 0:
            latch.clear()
            click.echo(f"{profile.name} is reset", err=True)
    if as_json:
        print_json({"rig": profile.name, "was_latched": reason, "is_latched": code != 0})
    return code


def _ask(made: Rig, name: str, yes: str | None, wait: float) -> int:
    """Have the operator show that somebody stands beside the rig; return the exit code."""
    from rig.cli.confirm import NotConfirmed, confirm

    if made.mechanism.stop_input() is None:
        try:
            return 0 if confirm(name, yes) else 2
        except NotConfirmed as error:
            click.echo(error, err=True)
            return 2
    if _pressed_and_released(made, wait):
        return 0
    click.echo(f"the emergency stop was not pressed and released within {wait:g} s", err=True)
    return 3


def _pressed_and_released(made: Rig, wait: float) -> bool:
    """Wait for a rising edge: the circuit is seen open, and closed after that."""
    with made.watching_stop() as is_pressed:
        clock = made.clock
        deadline = clock.now() + wait
        click.echo("press the emergency stop, and release it", err=True)
        was_open = False
        while clock.now() < deadline:
            pressed = is_pressed()
            if was_open and pressed is False:
                return True
            was_open = was_open or pressed is True
            clock.sleep_until(clock.now() + _LOOK_EVERY)
    return False
