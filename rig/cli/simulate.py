"""`rig simulate`: a rig's plant and emulated devices on a real bus, for another process."""

from __future__ import annotations

import gc
import sys
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import click

from rig.cli.names import (
    complete_rig,
    configs_option,
    json_option,
    seed_option,
    set_option,
    with_seed,
)
from rig.cli.number_option import NumberWithin
from rig.cli.tables import print_json
from rig.cli.terminal_line import TerminalLine

if TYPE_CHECKING:
    from rig.assembly.simulation_process import Simulation
    from rig.config import Profile
    from rig.runtime.stop import StopRequests

_REDRAW = 0.5  # of the status line, s


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--on",
    default="vcan0",
    show_default=True,
    metavar="INTERFACE",
    help="CHANNEL (of SocketCAN) or INTERFACE:CHANNEL of python-can, one for each CAN bus of the "
    "profile with commas between (vcan0,vcan1), or BUS=… each. A single one with a number "
    "counts on: vcan0 is vcan0,vcan1 for two buses. udp_multicast:GROUP stays on this host; its "
    "UDP port is 43113 and the number at the group's end, 43115 for 239.74.163.2.",
)
@click.option(
    "--for", "duration", type=NumberWithin(min=0.0, min_open=True), metavar="SECONDS",
    help="End by itself.",
)  # fmt: skip
@set_option
@seed_option
@configs_option
@json_option
def simulate(
    rig: str,
    on: str,
    duration: float | None,
    overrides: tuple[str, ...],
    seed: int | None,
    configs: Path | None,
    as_json: bool,
) -> int:
    """Put the emulated devices of RIG on a real bus, in real time, until Ctrl-C.

    In another terminal, `rig run EXPERIMENT --on` the same interface runs on them as it would
    on the rig; so does any other CANopen program. Serial buses become pseudo-terminals, whose
    paths are printed.
    """
    from rig.assembly import REGISTRY, check_profile, parse_interfaces
    from rig.assembly.buses import is_can
    from rig.assembly.simulation_process import open_simulation
    from rig.config import load_profile
    from rig.config.names import find_configs
    from rig.runtime.realtime import real_time
    from rig.runtime.stop import StopRequests

    profile = load_profile(rig, REGISTRY, with_seed(overrides, seed), find_configs(configs))
    check_profile(profile)
    has_can = any(map(is_can, profile.buses.values()))
    interfaces = parse_interfaces(on, profile) if has_can else {}
    with (
        StopRequests() as stop,
        open_simulation(profile, interfaces) as simulation,
        TerminalLine() as line,
        # Devices answer within a millisecond whatever else the machine does; so must these.
        real_time(profile.loop.priority),
    ):
        gc.enable()  # unlike a run this may live for days; what is there already stays frozen
        # From now on requests are read between two looks at the buses: `timeout` and impatient
        # people send two at once, of which none may tear the release of the interfaces.
        stop.shield()
        _introduce(profile, simulation)
        if as_json:  # now: who reads it wants the paths of the buses
            print_json(_as_data(profile, simulation))
        began = monotonic()
        _serve(simulation, line, stop, duration)
        summary = _summarise(simulation, monotonic() - began)
    click.echo(f"stopped {summary}", err=True)
    return 0


def _introduce(profile: Profile, simulation: Simulation) -> None:
    for bus, channel in simulation.channels.items():
        devices = [name for name, entry in profile.devices.items() if entry.bus == bus]
        click.echo(f"{bus} on {channel}: {', '.join(devices)}", err=True)
    for name in simulation.cameras:
        click.echo(f"{name} on a local socket, for `rig run` on the same interfaces", err=True)
    for name in simulation.left_out:
        click.echo(f"{name} hangs on no bus: another process cannot reach it", err=True)
    if simulation.has_hands:
        click.echo("hands on a local socket, for `rig commission` on the same interfaces", err=True)
    click.echo(f"simulating {profile.name}; Ctrl-C ends it", err=True)
    sys.stderr.flush()


def _as_data(profile: Profile, simulation: Simulation) -> dict[str, object]:
    """Return what is simulated, and where another process finds it."""
    return {
        "rig": profile.name,
        "buses": {
            bus: {
                "channel": channel,
                "devices": [name for name, of in profile.devices.items() if of.bus == bus],
            }
            for bus, channel in simulation.channels.items()
        },
        "cameras": list(simulation.cameras),
        "left_out": list(simulation.left_out),
        "hands": simulation.has_hands,
    }


def _serve(
    simulation: Simulation, line: TerminalLine, stop: StopRequests, duration: float | None
) -> None:
    began = last = monotonic()
    counts = _counts(simulation)
    while not stop.count and (duration is None or last - began < duration):
        until = monotonic() + _REDRAW
        simulation.rig.serve(lambda until=until: stop.count or monotonic() >= until)
        now, newer = monotonic(), _counts(simulation)
        span = now - last
        parts = [f"{now - began:7.1f} s"]
        for name, end in simulation.ends.items():
            came, went = newer[name][0] - counts[name][0], newer[name][1] - counts[name][1]
            parts.append(f"{name} {came / span:.0f} in {went / span:.0f} out /s")
            if end.lost:
                parts.append(f"{end.lost} refused")
            if end.trouble:
                parts.append(end.trouble)
        if simulation.rig.held_up:
            parts.append(f"held up {simulation.rig.held_up:.2f} s")
        line.draw("  ".join(parts))
        last, counts = now, newer


def _summarise(simulation: Simulation, span: float) -> str:
    parts = [f"after {span:.1f} s"]
    for name, end in simulation.ends.items():
        parts.append(f"{name}: {end.received} in, {end.sent} out, {end.lost} refused")
    if simulation.rig.held_up:
        parts.append(f"held up for {simulation.rig.held_up:.2f} s, in which its time stood still")
    return "; ".join(parts)


def _counts(simulation: Simulation) -> dict[str, tuple[int, int]]:
    return {name: (end.received, end.sent) for name, end in simulation.ends.items()}
