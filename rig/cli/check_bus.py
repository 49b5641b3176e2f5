"""`rig check --on`: who answers on the bus, beside what the profile says."""

from __future__ import annotations

import shlex
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import click

from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from rig.assembly.survey import Answer
    from rig.config import Profile

_HEADER = ("bus", "node", "device", "type", "vendor", "serial", "state", "verdict")
EXIT_DIFFERENT = 3


def check_buses(profile: Profile, on: str, *, as_json: bool) -> int:
    """Show who answers on the CAN buses of a profile; return the exit code."""
    from rig.assembly import Backend, backend_of, parse_interfaces
    from rig.assembly.survey import survey_buses
    from rig.assembly.survey_words import differences_in_words

    interfaces = {} if on == "hardware" else parse_interfaces(on, profile)
    # A CAN interface takes the place of CAN buses alone; on hardware, serial lines are asked, too.
    answers = survey_buses(profile, interfaces, tuple(profile.buses) if on == "hardware" else None)
    if as_json:
        print_json({"buses": [_as_data(answer) for answer in answers]})
    else:
        title = f"{profile.name} on {on}"
        print_tables([Table(title, _HEADER, [_row(answer) for answer in answers])])
    different = [answer for answer in answers if answer.differences]
    for clause in differences_in_words(answers):
        click.echo(clause, err=True)
    refused = _refused_calibrations(profile) if backend_of(on) is Backend.HARDWARE else []
    for sentence in refused:
        click.echo(sentence, err=True)
    if not different:
        click.echo(f"{len(answers)} of {len(answers)} nodes are as the profile says", err=True)
        return EXIT_DIFFERENT if refused else 0
    click.echo(_advise(profile, on, answers), err=True)
    return EXIT_DIFFERENT


def _refused_calibrations(profile: Profile) -> list[str]:
    """Return why calibrations in force keep the rig from being run on hardware."""
    from rig.config.calibration_state import calibration_states

    states = calibration_states(profile, datetime.now(UTC).date(), on_hardware=True)
    return [f"{state.name}: {state.sentence}" for state in states if state.problems]


def _advise(profile: Profile, on: str, answers: list[Answer]) -> str:
    """Say what to do next."""
    from rig.assembly.survey_words import say_renumbered

    if all(answer.found is None for answer in answers):
        return (
            "nobody answers: look at power, cable, termination and bit rate (ip -details link "
            f"show); a simulated rig is started by: {_simulated(profile, on)}"
        )
    if any(answer.found is not None and answer.found.answers > 1 for answer in answers):
        return "take one of the devices that share a number off the bus, and give it another"
    renumbered = say_renumbered(profile, answers)
    return renumbered or "look at node numbers and power, or correct the profile"


def _simulated(profile: Profile, on: str) -> str:
    """Return the command for a simulated rig that the same question finds."""
    from rig.assembly.buses import is_can
    from rig.assembly.on_interfaces import own_interfaces

    command = f"rig simulate {profile.argument}"
    if on != "hardware":
        return f"{command} --on {shlex.quote(on)}"
    lines = [name for name, entry in profile.buses.items() if not is_can(entry)]
    can = [name for name, entry in profile.buses.items() if is_can(entry)]
    after = [f"--set buses.{name}.port=PORT, which it prints" for name in lines]
    if can:
        own = own_interfaces(profile)
        command += f" --on {shlex.quote(own or 'vcan0')}"
        if own is None:  # its adapter is taken while another program has it
            after.append("--on vcan0 in the place of --on hardware")
        elif any(not word.startswith(("vcan", "udp_multicast:")) for word in own.split(",")):
            # What an adapter sends alone nobody acknowledges, so it does not come back either.
            command += " (on another computer of that bus, unless it is a vcan)"
    with_what = f"; then look again with {' and '.join(after)}" if after else ""
    return f"{command}{with_what}"


def _as_data(answer: Answer) -> dict[str, object]:
    found = None if answer.found is None else answer.found._asdict()
    return {**answer._asdict(), "found": found}


def _row(answer: Answer) -> tuple[str, ...]:
    found = answer.found
    verdict = ", ".join(answer.differences) or "ok"
    name = answer.name or "-"
    node = f"0x{answer.node:02X}"
    if found is None:
        return (answer.bus, node, name, "-", "-", "-", "-", verdict)
    vendor = "-" if found.vendor is None else f"0x{found.vendor:X}"
    serials = " ".join(f"{serial:X}" for serial in found.serials) or "-"
    return (answer.bus, node, name, found.kind or "-", vendor, serials, found.state, verdict)
