"""`rig status`: the whole state of a rig on one screen, and what comes next."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from rig.cli.milestones import Milestone, loops_of_rig, margin_missed
from rig.cli.names import (
    complete_rig,
    configs_option,
    json_option,
    need_rig,
    out_option,
    set_option,
)
from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from rig.calibration.procedure import AnyProcedure
    from rig.config import Profile
    from rig.config.models import Calibration


_RUN: Final = "rig run EXPERIMENT --on hardware"
_VALID: Final = "valid"


@click.command()
@click.argument("rig", required=False, callback=need_rig, shell_complete=complete_rig)
@out_option
@set_option
@configs_option
@json_option
def status(
    rig: str, out: Path, overrides: tuple[str, ...], configs: Path | None, as_json: bool
) -> int:
    """Show how far RIG has come on its way to hardware, and which command comes next.

    Nothing is sent to the rig: `rig doctor RIG` says all that there is to say of the computer,
    `rig check RIG --on hardware` who answers.
    """
    from rig.assembly import REGISTRY
    from rig.config import load_profile
    from rig.config.calibration_state import sentences_of_bases
    from rig.config.names import find_configs
    from rig.config.records import sentences_of_records

    search = find_configs(configs)
    profile = load_profile(rig, REGISTRY, overrides, search)
    steps = way(profile, search, out)
    stages = [*steps, *loops_of_rig(profile, out), *_last_runs(profile, out)]
    title = ", ".join(filter(None, (profile.name, profile.description)))
    following, simulated = _following(steps), _in_simulation(profile, search, steps)
    notes = [*sentences_of_bases(profile), *sentences_of_records(profile, search)]
    if as_json:
        told = [stage._asdict() for stage in stages]
        coming = {"next": following or None, "next_in_simulation": simulated}
        print_json({"stages": told, **coming, "notes": notes})
        return 0
    rows = [(stage.what, stage.state) for stage in stages]
    print_tables([Table(title, ("what", "state"), rows)])
    for sentence in notes:
        click.echo(f"note: {sentence}", err=True)
    tell_both(profile, search, steps)
    return 0


def tell_both(profile: Profile, search: Sequence[Path], steps: Sequence[Milestone]) -> None:
    """Say which command comes next, and which one does in simulation if that is another."""
    following, simulated = _following(steps), _in_simulation(profile, search, steps)
    click.echo(f"next: {_with_reason(following, steps)}", err=True)
    if simulated is not None and simulated != following:
        click.echo(f"next in simulation: {_with_reason(simulated, steps)}", err=True)


def way(profile: Profile, search: Sequence[Path], out: Path | None = None) -> list[Milestone]:
    """Return the milestones on a rig's way to hardware, in their order.

    Parameters
    ----------
    profile : Profile
        The rig's.
    search : sequence of Path
        The folders of configurations.
    out : Path, optional
        Where runs are kept. Without it the computer is left out: the rig has just moved on it.
    """
    return [
        *_valid(profile),
        _latch(profile),
        *([] if out is None else [_computer(profile, out)]),
        _commissioned(profile, search),
        *_calibrated(profile, search),
        *_tuned(profile, out),
    ]


def _following(stages: Sequence[Milestone]) -> str:
    return next((stage.remedy for stage in stages if stage.remedy), _RUN)


def _in_simulation(
    profile: Profile, search: Sequence[Path], steps: Sequence[Milestone]
) -> str | None:
    """Return the command that comes next without hardware; None: there is nothing to simulate."""
    from rig.cli.outdated import procedures_outdated

    if profile.plant is None:
        return None
    remedies = {step.what: step.remedy for step in steps if step.remedy}
    if _VALID in remedies:
        return remedies[_VALID]
    if _lacks_calibration(profile, search):
        return f"rig calibrate {profile.argument} --all"
    again = procedures_outdated(profile)
    if again:
        return f"rig calibrate {profile.argument} {' '.join(again)} --replace"
    tunes = (remedy for what, remedy in remedies.items() if what.startswith("tuned"))
    return next(tunes, f"rig run EXPERIMENT --rig {profile.argument}")


def _lacks_calibration(profile: Profile, search: Sequence[Path]) -> bool:
    """Return whether a procedure that the rig is fit for has found nothing yet, on any backend."""
    from rig.calibration.catalogue import procedures

    return any(
        not all(_entries_of(profile, search, name, procedure)) and not _lack(procedure, profile)
        for name, procedure in procedures(profile).items()
    )


def _entries_of(
    profile: Profile, search: Sequence[Path], name: str, procedure: AnyProcedure
) -> list[list[dict[str, object]]]:
    """Return what a procedure, or one that finds the same, has found of each of its targets."""
    from rig.calibration import store

    found, finders = [], {name, *procedure.shares}
    for target in procedure.targets(profile):
        content = store.in_force(profile, search, target)
        entries = [] if content is None else content["measured"]
        found.append([entry for entry in entries if entry["procedure"] in finders])
    return found


def tell_next(
    profile: Profile, search: Sequence[Path], *, simulated: bool = False, has_run: bool = False
) -> None:
    """Say which command comes next on a rig's way to hardware, or in simulation, and why.

    After a simulated run (`has_run`) nobody need be told to run.
    """
    steps = way(profile, search)
    if not simulated:
        click.echo(f"next: {_with_reason(_following(steps), steps)}", err=True)
        return
    following = _in_simulation(profile, search, steps)
    if following is not None and not (has_run and following.startswith("rig run")):
        click.echo(f"next in simulation: {_with_reason(following, steps)}", err=True)


def _with_reason(command: str, steps: Sequence[Milestone]) -> str:
    """Return a command with the milestone that asks for it."""
    for step in steps:
        if step.remedy == command:
            why = "it is not valid" if step.what == _VALID else f"{step.what}: {step.state}"
            return f"{command}  ({why})"
    if command.startswith("rig calibrate"):
        return f"{command}  (not all is calibrated)"
    better = [step for step in steps if step.better]
    if better:
        told = "; ".join(
            f"what {step.what!r} lacks may be found by: {step.better}" for step in better
        )
        return f"{command}  (nothing keeps it from running; {told})"
    return f"{command}  (nothing is missing)"


def _valid(profile: Profile) -> list[Milestone]:
    """Return what keeps a profile from being used at all: nothing else is worth doing before."""
    from rig.assembly import check_profile
    from rig.hal import ConfigurationError, SeveralErrors

    try:
        check_profile(profile)
    except ConfigurationError as error:
        first, *others = SeveralErrors.told_by(error)
        more = f", and {len(others)} more" if others else ""
        told = first.partition("\n")[0]  # its places and excerpts are no lines of a table
        return [Milestone(_VALID, f"no: {told}{more}", f"rig check {profile.argument}")]
    return []


def _computer(profile: Profile, out: Path) -> Milestone:
    """Return whether this computer has what the rig does not run on hardware without."""
    from rig.doctor.computer import look_at_computer
    from rig.doctor.look import Fitness
    from rig.doctor.wiring import look_at_wiring

    looks = [*look_at_computer(out, profile.loop.priority), *look_at_wiring(profile)]
    lacking = [f"{look.what}: {look.found}" for look in looks if look.verdict is Fitness.NO]
    if lacking:
        more = f", and {len(lacking) - 1} more" if len(lacking) > 1 else ""
        return Milestone("computer", f"no: {lacking[0]}{more}", f"rig doctor {profile.argument}")
    return Milestone("computer", "nothing is missing without which it does not run")


def _commissioned(profile: Profile, search: Sequence[Path]) -> Milestone:
    from rig.assembly import Backend
    from rig.commissioning.permission import verdict_of
    from rig.commissioning.session import has_steps
    from rig.config.records import record_folders

    if not has_steps(profile):
        return Milestone(
            "commissioned", f"no: there is no acceptance test of a {profile.mechanism}"
        )
    verdict = verdict_of(profile, Backend.HARDWARE, record_folders(profile.files, search))
    if verdict.lack:
        remedy = f"rig commission {profile.argument} --on hardware"
        return Milestone("commissioned", f"no: {verdict.whole_lack}", remedy)
    return Milestone("commissioned", f"yes, {verdict.digest}")


def _latch(profile: Profile) -> Milestone:
    from rig.experiment.fault_latch import FaultLatch, FaultLatched

    try:
        FaultLatch.of(profile).check()
    except FaultLatched as fault:
        return Milestone("last fault", fault.told, fault.remedy)
    return Milestone("last fault", "none is latched")


def _calibrated(profile: Profile, search: Sequence[Path]) -> list[Milestone]:
    """Return what each procedure has found, with its age, and whether hardware takes it."""
    from rig.calibration.catalogue import procedures
    from rig.cli.outdated import changes_since
    from rig.config.basis import say_changes

    stages = []
    today = datetime.now(UTC).date()
    for name, procedure in procedures(profile).items():
        other = [of for of in procedure.targets(profile) if of in profile.foreign]
        if other:
            owner = profile.foreign[other[0]].provenance.profile
            state = f"no: the calibration of its name belongs to another rig: {owner}"
            stages.append(Milestone(f"calibrated: {name}", state, f"rig check {profile.argument}"))
            continue
        found = _entries_of(profile, search, name, procedure)
        remedy = f"rig calibrate {profile.argument} {name} --on hardware"
        lack = "" if all(found) else _lack(procedure, profile)
        if lack:
            stages.append(Milestone(f"calibrated: {name}", f"not on this rig: {lack}"))
            continue
        if not all(found):
            stages.append(Milestone(f"calibrated: {name}", f"no ({procedure.title})", remedy))
            continue
        entries = [entry for of_target in found for entry in of_target]
        date = min(str(entry["date"])[:10] for entry in entries)
        until = min(str(entry.get("valid_until", "9999")) for entry in entries)
        where = sorted({str(entry.get("backend", "nobody says where")) for entry in entries})
        state = f"{date}, on {', '.join(where)}, until {until}"
        changes = changes_since(name, procedure, profile, entries)
        if changes:
            state = f"of another profile: {say_changes(changes)} ({state})"
            stages.append(Milestone(f"calibrated: {name}", state, f"{remedy} --replace"))
        elif until < today.isoformat():
            stages.append(
                Milestone(f"calibrated: {name}", f"expired: {state}", f"{remedy} --replace")
            )
        elif where != ["hardware"]:
            state += ": hardware does not take it"
            stages.append(Milestone(f"calibrated: {name}", state, f"{remedy} --replace"))
        else:
            stages.append(Milestone(f"calibrated: {name}", state))
    return stages


def _lack(procedure: AnyProcedure, profile: Profile) -> str:
    """Return what the rig lacks for a procedure, which is nothing that is missing then."""
    from rig.calibration.recording import RigLacks

    try:
        procedure.check_rig(profile)
    except RigLacks as lack:
        return str(lack).partition(";")[0]
    return ""


def _tuned(profile: Profile, out: Path | None) -> list[Milestone]:
    from rig.assembly import REGISTRY
    from rig.config.laid_over import TUNED
    from rig.tuning.attempt import last_attempt

    if REGISTRY.bench(profile.mechanism) is None:
        return []
    found = {
        name.removeprefix(TUNED): calibration
        for name, calibration in profile.calibrations.items()
        if name.startswith(TUNED)
    }
    remedy = f"rig tune {profile.argument}"
    tried = None if out is None else last_attempt(out, profile.name)
    in_vain = ""
    if tried is not None and not tried.is_put and tried.objections:
        remedy = tried.for_more(profile.argument)
        in_vain = (
            f"; {tried.date[:10]} {tried.generations} generations for {tried.law} found no better "
            f"ones: {tried.objections[0]}"
        )
    if not found:
        state = f"no: the profile's own gains are in force{in_vain}"
        return [Milestone("tuned", state, remedy)]
    return [_of_gains(law, its, profile) for law, its in found.items()]


def _of_gains(law: str, calibration: Calibration, profile: Profile) -> Milestone:
    """Return the gains that were found for a law, and whether they are this rig's as it is now."""
    from rig.config.basis import changes_of, say_changes

    missed, better = margin_missed(law, calibration, profile.argument)
    state = _gains_of(calibration) + missed
    changes = changes_of(calibration, profile)
    if not changes:
        return Milestone(f"tuned: {law}", state, better=better)
    remedy = f"rig tune {profile.argument} --controller {law} --replace"
    return Milestone(
        f"tuned: {law}", f"of another profile: {say_changes(changes)} ({state})", remedy
    )


def _gains_of(calibration: Calibration) -> str:
    """Return when gains were found, for which motion if for one alone, and where they are."""
    wanted = calibration.provenance.conditions.get("tuned for", "")
    alone = f", for {wanted}: other motions may need others" if wanted else ""
    return f"{calibration.provenance.date[:10]}{alone}, {calibration.file}"


def _last_runs(profile: Profile, out: Path) -> list[Milestone]:
    """Return how the last runs of the rig ended, on hardware and in simulation."""
    from rig.cli.listing import describe_run
    from rig.run_names import list_runs

    runs = [run for run in map(describe_run, list_runs(out)) if run.rig == profile.name]
    stages = []
    for title, is_wanted in (("last run on hardware", True), ("last simulated run", False)):
        of = [run for run in runs if (run.backend == "hardware") is is_wanted]
        if not of:
            stages.append(Milestone(title, "-"))
            continue
        last = max(of, key=lambda run: run.started or "")
        when = (last.started or "-")[:19].replace("T", " ")
        stages.append(Milestone(title, f"{last.status}, {last.experiment}, {when}, {last.path}"))
    return stages
