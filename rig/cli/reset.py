"""`rig reset`: an operator says that the cause of a fault was found and mended."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rig.cli.names import complete_rig, configs_option, json_option, set_option, yes_option
from rig.cli.number_option import NumberWithin
from rig.cli.on_option import OnBackend
from rig.cli.tables import print_json

if TYPE_CHECKING:
    from rig.assembly import Rig
    from rig.cli.stop_hands import StopHands

_LOOK_EVERY = 0.02
"""s; nobody presses and releases a mushroom button in less than twice of it."""


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--on", "on", type=OnBackend(), default="hardware", show_default=True,
    help="Where the emergency stop is read, as for `rig run`; elsewhere than on hardware it is a "
    "rehearsal.",
)  # fmt: skip
@click.option(
    "--wait", type=NumberWithin(min=0), default=60.0, show_default=True, metavar="SECONDS",
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
    without a contact asks for its name. In simulation that is rehearsed: simulated hands press and
    release the stop, unless simulation.faults does, and nothing is latched or reset.
    """
    from rig.assembly import REGISTRY, Backend, backend_of, build_rig
    from rig.cli.stop_hands import hands_at
    from rig.config import load_profile
    from rig.config.names import find_configs
    from rig.experiment.fault_latch import FaultLatch

    backend = backend_of(on)
    other = None if on in list(Backend) else on
    profile = load_profile(rig, REGISTRY, overrides, find_configs(configs))
    latch = FaultLatch(profile.name)
    reason = latch.reason()
    code = 0
    if backend is not Backend.HARDWARE:
        made = build_rig(profile, backend, other)
        code = _ask(made, profile.name, yes, wait, hands_at(made, other))
        if code == 0:
            click.echo(
                f"a rehearsal on {on}: on hardware this resets {profile.name}; "
                f"{'it has no latched fault' if reason is None else 'it stays latched'}", err=True,
            )  # fmt: skip
        if as_json:
            print_json({"rig": profile.name, "was_latched": reason,
                        "is_latched": reason is not None, "rehearsed": code == 0})  # fmt: skip
        return code
    if reason is None:
        click.echo(f"{profile.name} has no latched fault", err=True)
    else:
        click.echo(f"{profile.name} is latched: {reason}", err=True)
        made = build_rig(profile, Backend.HARDWARE, other)
        code = _ask(made, profile.name, yes, wait)
        if code == 0:
            latch.clear()
            click.echo(f"{profile.name} is reset", err=True)
    if as_json:
        print_json({"rig": profile.name, "was_latched": reason, "is_latched": code != 0})
    return code


def _ask(made: Rig, name: str, yes: str | None, wait: float, hands: StopHands | None = None) -> int:
    """Have the operator show that somebody stands beside the rig; return the exit code."""
    from rig.cli.confirm import NotConfirmed, confirm

    if made.mechanism.stop_input() is None:
        try:
            return 0 if confirm(name, yes) else 2
        except NotConfirmed as error:
            click.echo(error, err=True)
            return 2
    lack = _wait_for_edge(made, wait, hands)
    if lack is None:
        return 0
    click.echo(lack, err=True)
    return 3


def _wait_for_edge(made: Rig, wait: float, hands: StopHands | None) -> str | None:
    """Wait for the circuit to be seen open, and closed after that; return what did not come."""
    seen: bool | None = None
    was_open = False
    with made.watching_stop() as is_pressed:
        clock = made.clock
        start = clock.now()
        click.echo("press the emergency stop, and release it", err=True)
        while clock.now() < start + wait:
            if hands is not None:
                hands.act(clock.now() - start)
            pressed = is_pressed()
            if was_open and pressed is False:
                return None
            was_open = was_open or pressed is True
            seen = seen if pressed is None else pressed
            clock.sleep_until(clock.now() + _LOOK_EVERY)
    missing = f"the emergency stop was not pressed and released within {wait:g} s"
    if was_open:
        return (
            f"{missing}: it is pressed, and nobody has released it: turn or pull its button, and "
            "say the same again; if it is released, its circuit is open: a wire is off"
        )
    if seen is None:
        return f"{missing}: the device that reads it has told nothing of it"
    return f"{missing}: its circuit was closed all the time"
