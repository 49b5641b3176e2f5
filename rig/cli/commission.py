"""`rig commission`: the acceptance test of a physical rig, step by step."""

from __future__ import annotations

import json
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import click

from rig.cli.confirm import confirm
from rig.cli.names import (
    complete_rig,
    configs_option,
    json_option,
    out_option,
    seed_option,
    set_option,
    with_seed,
    yes_option,
)
from rig.cli.on_option import OnBackend
from rig.cli.status import tell_next
from rig.cli.tables import Table, print_data, print_tables
from rig.terminals import is_terminal

if TYPE_CHECKING:
    from rig.assembly import Rig
    from rig.commissioning.operator import Operator
    from rig.commissioning.questions import Rehearsed
    from rig.commissioning.site import Site
    from rig.commissioning.step import AcceptanceStep
    from rig.commissioning.stopping import StepInterrupts
    from rig.config import Profile

EXIT_FAILED = 3
_UNDER_WAY = 20e-3
"""For so long frames may be under way, s."""


class _Options(TypedDict):
    """The options, as click has read them."""

    on: str
    answers: Path | None
    anew: bool
    dry_run: bool
    operator: str | None
    valid_for: int
    yes: str | None
    out: Path
    overrides: tuple[str, ...]
    seed: int | None
    configs: Path | None
    as_json: bool


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.option(
    "--on", "on", type=OnBackend(), default="virtual", show_default=True, help="As for `rig run`."
)
@click.option(
    "--answers", type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="YAML file of what to answer, by the keys that --dry-run shows.",
)  # fmt: skip
@click.option("--anew", is_flag=True, help="Begin again, whatever has passed before.")
@click.option(
    "--dry-run", is_flag=True, help="Show the steps and the keys of --answers; open nothing."
)
@click.option(
    "--operator", default=None, help="Who tests, kept with each step; default: the user's name."
)
@click.option(
    "--valid-for", type=click.IntRange(1, 36500), default=365, show_default=True, help="Days."
)
@yes_option
@out_option
@set_option
@seed_option
@configs_option
@json_option
def commission(rig: str, **options: Unpack[_Options]) -> int:
    """Test RIG step by step before it is used, and write configs/commissioning/RIG.yaml.

    Nothing is energised before its step. What has passed is kept: after a failure, mend the rig
    and say the same again. Simulated hands do in a simulation what a person does at a rig.
    """
    from rig.assembly import REGISTRY, check_profile
    from rig.commissioning.answers import check_answers
    from rig.commissioning.record import read_answers
    from rig.commissioning.session import steps_of
    from rig.commissioning.stopping import StepInterrupts
    from rig.config import load_profile
    from rig.config.names import find_configs

    search = find_configs(options["configs"])
    overrides = with_seed(options["overrides"], options["seed"])
    profile = load_profile(rig, REGISTRY, overrides, search)
    check_profile(profile)
    steps = steps_of(profile)
    file, is_dry = options["answers"], options["dry_run"]
    given = {} if file is None else read_answers(file)
    asked = _asked_in(profile, steps) if is_dry or file is not None else None
    if asked is not None and file is not None:  # what is wrong is said before anything moves
        check_answers(file, given, asked, None if is_dry else ())
    if asked is not None and is_dry:
        return _show(profile, steps, asked, as_json=options["as_json"])
    with StepInterrupts() as stop:
        return _commission(profile, steps, search, options, stop, asked)


def _commission(
    profile: Profile,
    steps: Sequence[AcceptanceStep],
    search: Sequence[Path],
    options: _Options,
    stop: StepInterrupts,
    asked: Rehearsed | None,
) -> int:
    """Take the steps; a request to stop ends them with the rig made safe.

    `asked`, of a test with a file of answers, is what that has to answer.
    """
    from rig.assembly import Backend, backend_of
    from rig.commissioning.answers import check_answers
    from rig.commissioning.record import FOLDER, missing, read_answers
    from rig.commissioning.session import CommissioningFacts, begin
    from rig.commissioning.session import commission as commission_rig
    from rig.config.names import say_where
    from rig.experiment.ending import EXIT_INTERRUPTED
    from rig.hal import ConfigurationError
    from rig.hal.files import check_writable

    on, backend = options["on"], backend_of(options["on"])
    if backend is Backend.SIM:
        raise ConfigurationError("--on sim has no buses and no drivers, so nothing to test")
    circumstances = CommissioningFacts(backend.value, options["operator"], options["valid_for"])
    record = begin(profile, search, circumstances, anew=options["anew"])
    lacking = missing(record, [step.name for step in steps])
    if backend is Backend.HARDWARE:
        _announce(profile, [step for step in steps if step.name in lacking], search)
        if not confirm(profile.name, options["yes"]):
            return 2
    for folder, what in (
        (search[0] / FOLDER, f"the record of {profile.name}"),
        (options["out"], "run folders"),
    ):
        check_writable(folder, what)
    site = _site(profile, options, stop)
    file = options["answers"]
    if asked is not None and file is not None:
        check_answers(file, read_answers(file), asked, lacking)
    click.echo(f"the record of {profile.name} is kept in {say_where(search[0])}", err=True)
    seed = "" if options["seed"] is None else f" --seed {options['seed']}"
    by = "" if options["operator"] is None else f" --operator {shlex.quote(options['operator'])}"
    again = f"rig commission {profile.argument} --on {on}{seed}{by}"
    try:
        stopped = commission_rig(
            site, record, steps, search[0], lambda text: click.echo(text, err=True),
            options["operator"],
        )  # fmt: skip
    except (KeyboardInterrupt, click.Abort) as error:  # the latter where somebody is asked
        safe = f"the rig could not be made safe: {error}" if str(error) else "the rig is made safe"
        click.echo(f"interrupted; {safe}; what has passed is kept, go on with: {again}", err=True)
        return EXIT_INTERRUPTED
    if options["as_json"]:
        print_data(json.dumps(record, indent=2, ensure_ascii=False, default=str))
    if stopped is not None:
        _keep(again, options["out"], stopped)
        click.echo(f"stopped at {stopped}", err=True)
        click.echo(f"mend it, and go on with: {again}", err=True)
        return EXIT_FAILED
    click.echo(f"commissioned, digest {record['digest']}: {search[0]}/commissioning", err=True)
    if backend is Backend.HARDWARE:
        tell_next(profile, search)
    else:
        click.echo(f"a rehearsal; next: rig commission {profile.argument} --on hardware", err=True)
    return 0


def _announce(profile: Profile, steps: Sequence[AcceptanceStep], search: Sequence[Path]) -> None:
    """Say what will be done, how far it may go and what `rig check` warns of.

    Raises
    ------
    DeviceError
        No step with the rig can be taken, whatever the operator says.
    """
    from rig.assembly import check_fitness
    from rig.cli.announce import limits
    from rig.cli.check_hardware import refusals_of
    from rig.cli.check_warnings import tell_warnings

    check_fitness(profile)
    told = ":" if steps else " has passed every step; nothing is done again"
    click.echo(f"the acceptance test of {profile.name}{told}", err=True)
    for line in (*(f"  {step.name}: {step.does}" for step in steps), *limits(profile)):
        click.echo(line, err=True)
    tell_warnings(profile, search)
    for sentence in refusals_of(profile):
        click.echo(f"until it is mended, no run on hardware: {sentence}", err=True)


def _keep(command: str, runs: Path, stopped: str) -> None:
    """Have `rig explain` tell what stopped a step; the runs of its steps are older than that."""
    from rig.explaining.refused_run import keep_refusal
    from rig.run_names import RUNS

    where = [] if runs == RUNS else ["--runs", str(runs)]
    keep_refusal([*shlex.split(command)[1:], *where], EXIT_FAILED, stopped, time.time())


def _site(profile: Profile, options: _Options, stop: StepInterrupts) -> Site:
    """Return where the steps are taken; whatever closes a rig there is not interrupted."""
    from rig.assembly import Backend, backend_of, build_rig
    from rig.cli.stop_hands import world_on
    from rig.commissioning.site import Site

    on, backend = options["on"], backend_of(options["on"])
    other = None if on in list(Backend) else on
    hands = world_on(profile, backend, other)

    def make_rig(its: Profile) -> Rig:
        rig = _rested(build_rig(its, backend, other))
        rig.closing = stop.held_back
        return rig

    operator = _operator(backend.is_simulated or hands is not None, options["answers"])
    return Site(profile, make_rig, operator, options["out"], other, hands)


def _operator(is_simulated: bool, answers: Path | None) -> Operator:
    """Return who stands at the rig: simulated hands, a person, or answers from a file."""
    from rig.commissioning.operator import Person, SimulatedOperator, WrittenAnswers
    from rig.commissioning.record import read_answers
    from rig.hal import ConfigurationError

    hands: Operator
    if is_simulated:
        hands = SimulatedOperator()
    else:
        if answers is None and not is_terminal(sys.stdin):
            raise ConfigurationError("there is no terminal to ask: give --answers FILE")
        hands = Person(lambda text: click.echo(f"  >>> {text}", err=True), click.prompt)
    return hands if answers is None else WrittenAnswers(read_answers(answers), hands)


def _rested(rig: Rig) -> Rig:
    """Return a rig whose interfaces are silent again.

    What the step before sent last may be under way when its interface is closed; whoever opens it
    next would take it for another master's.
    """
    if not rig.backend.is_simulated:
        rig.clock.sleep_until(rig.clock.now() + _UNDER_WAY)
    return rig


def _asked_in(profile: Profile, steps: Sequence[AcceptanceStep]) -> Rehearsed:
    """Go through the test on emulated devices, and return what is asked."""
    from rig.commissioning.questions import questions_of

    click.echo("gone through on emulated devices to see what is asked …", err=True)
    asked = questions_of(profile, steps)
    if asked.stopped is not None:
        click.echo(f"what is asked is not known any further: {asked.stopped}", err=True)
    return asked


def _show(
    profile: Profile, steps: Sequence[AcceptanceStep], rehearsed: Rehearsed, *, as_json: bool
) -> int:
    """Show the steps, and by which keys a file of answers answers what they ask."""
    questions = rehearsed.questions
    if as_json:
        told = [{"step": s.name, "does": s.does, "expects": s.expects} for s in steps]
        content = {
            "rig": profile.name, "steps": told, "answers": [q._asdict() for q in questions],
            "answers_lack": rehearsed.stopped,
        }  # fmt: skip
        print_data(json.dumps(content, indent=2, ensure_ascii=False))
        return 0
    rows = [(step.name, step.does, step.expects) for step in steps]
    title = f"acceptance test of {profile.name}"
    header = ("key", "step", "what is asked", "simulated hands answer")
    asked = [(*question[:3], question.simulated or "none") for question in questions]
    print_tables([
        Table(title, ("step", "what happens", "what is expected"), rows),
        Table("keys of a file for --answers", header, asked),
    ])  # fmt: skip
    click.echo(
        "a number that ends a key is what was set when it was asked; another rig may come to "
        "another one", err=True,
    )  # fmt: skip
    return 0
