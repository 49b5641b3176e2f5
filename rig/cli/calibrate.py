"""`rig calibrate`: find what a profile cannot know, and keep it with its history."""

from __future__ import annotations

import getpass
import shlex
import sys
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rig.cli.calibration_found import as_data, show_found
from rig.cli.given_options import given_options
from rig.cli.loops import known_loops, loops_of
from rig.cli.names import (
    complete_rig,
    configs_option,
    json_option,
    out_option,
    seed_option,
    set_option,
    with_seed,
)
from rig.cli.on_option import OnBackend
from rig.cli.status import tell_next
from rig.cli.tables import Table, print_json, print_tables
from rig.terminals import is_terminal

if TYPE_CHECKING:
    from rig.assembly import Backend
    from rig.calibration.procedure import AnyProcedure
    from rig.calibration.session import Calibrated
    from rig.calibration.store import Circumstances
    from rig.config import Profile
    from rig.experiment.run import Result
    from rig.hal.closed_loop import ClosedLoop

_DAY = 86_400.0


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@click.argument("procedures", nargs=-1, metavar="[PROCEDURE]...")
@click.option("--all", "every", is_flag=True, help="Every procedure of the rig, in order.")
@click.option(
    "--yes", is_flag=False, flag_value="", metavar="[NAME]",
    help="The rig's name: on hardware, in the place of typing it. Alone: in simulation.",
)  # fmt: skip
@click.option("--dry-run", is_flag=True, help="Show what would move and how far; open nothing.")
@click.option(
    "--on", "on", type=OnBackend(), default="virtual", show_default=True,
    help="As for `rig run`.",
)  # fmt: skip
@click.option(
    "--from", "earlier", multiple=True, metavar="RUN",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    help="Go on from a recorded run of the procedure: only what it lacks is recorded.",
)  # fmt: skip
@click.option(
    "--readings", type=click.Path(path_type=Path, dir_okay=False),
    help="File of what the reference instruments showed: quantity,stretch,value lines.",
)  # fmt: skip
@click.option(
    "--views", type=click.Path(path_type=Path, exists=True),
    help="Folder of images, or a video, of a board that was shown to the camera, for the lens.",
)  # fmt: skip
@click.option(
    "--board", default="10x7x8mm", show_default=True,
    help="That chessboard: squares across and down, and the side of one.",
)  # fmt: skip
@click.option("--replace", is_flag=True, help="Replace a better or an unreadable calibration.")
@click.option("--operator", default=None, help="Who calibrates; default: the user's name.")
@click.option("--temperature", help="For the record, as in '23 degC'.")
@click.option("--supply", help="Supply pressure, for the record, as in '7 bar'.")
@click.option(
    "--valid-for", type=click.IntRange(1, 36500), default=365, show_default=True, help="Days."
)
@click.option(
    "--history",
    "history_of",
    metavar="DEVICE",
    help="Show every kept calibration, and which is in force.",
)
@click.option(
    "--restore", "restored", metavar="DEVICE[/DATE]",
    help="Put the calibration of that date in force again, or with `profile` for a date the "
    "profile's own values; without a date, list them.",
)  # fmt: skip
@click.option(
    "--diff", nargs=2, metavar="A B", help="Compare two calibration files, or one with `profile`."
)
@click.option("--uncommissioned", metavar="REASON",
              help="Why hardware that is not commissioned is moved all the same.")  # fmt: skip
@out_option
@set_option
@seed_option
@configs_option
@json_option
def calibrate(rig: str, **options: Any) -> int:
    """Calibrate RIG by PROCEDURE..., and write configs/calibration/RIG/DEVICE.yaml.

    Without a procedure, list them. A procedure records a run within the rig's limits, fits
    what it recorded, draws a page into the run folder and writes the file; the older file is
    kept. Ctrl-C leaves the old calibration in force and the recording as it is: go on with
    --from RUN.
    """
    from rig.cli.calibration_files import restore, show_difference, show_history
    from rig.config.names import find_configs

    search, as_json = find_configs(options["configs"]), options["as_json"]
    options["overrides"] = with_seed(options["overrides"], options["seed"])
    if options["diff"]:
        return show_difference(search, rig, *options["diff"], as_json=as_json)
    if options["restored"]:
        return restore(search, rig, options["restored"], as_json=as_json)
    if options["history_of"]:
        return show_history(search, rig, options["history_of"], as_json=as_json)
    from rig.assembly import REGISTRY
    from rig.calibration.catalogue import pick, procedures
    from rig.config import load_profile

    profile = load_profile(rig, REGISTRY, options["overrides"], search)
    known = procedures(profile)
    if not options["procedures"] and not options["every"]:
        _show_procedures(rig, profile, known.values(), as_json=as_json)
        return 0
    chosen = pick(profile, tuple(known) if options["every"] else options["procedures"])
    done: list[dict[str, object]] = []
    loops: dict[str, ClosedLoop] = {}
    code = 0
    for procedure in chosen:
        # Each builds on what the one before has found.
        profile = load_profile(rig, REGISTRY, options["overrides"], search)
        code = _calibrate(procedure, profile, search, options, done, loops)
        if code:
            break
    _tell_loops(profile, loops, quiet=as_json)
    if as_json:
        print_json(done)
    if code:
        return code
    profile = load_profile(rig, REGISTRY, options["overrides"], search)
    tell_next(profile, search, simulated=options["on"] != "hardware")
    return 0


def _show_procedures(
    rig: str, profile: Profile, known: Iterable[AnyProcedure], *, as_json: bool
) -> None:
    found = [(p.name, p.targets(profile), p.title) for p in known]
    if as_json:
        print_json([dict(zip(("name", "writes", "title"), one, strict=True)) for one in found])
    elif found:
        rows = [(name, ", ".join(targets), title) for name, targets, title in found]
        print_tables([Table(f"procedures of {rig}", ("procedure", "writes", "what"), rows)])
    else:
        said = f"there is no procedure for {rig}: a {profile.mechanism} has none"
        click.echo(said, err=True)


def _calibrate(
    procedure: AnyProcedure,
    profile: Profile,
    search: Sequence[Path],
    options: dict[str, Any],
    done: list[dict[str, object]],
    known: dict[str, ClosedLoop],
) -> int:
    """Calibrate by one procedure.

    What was found is appended to what is `done`, as plain data; the loops as they are now take the
    place of those that are `known`.
    """
    from rig.assembly import Backend, backend_of
    from rig.calibration.preview import preview
    from rig.calibration.procedure import FilesOffered
    from rig.calibration.recording import CalibrationRefused, NoFiles, Recording, RigLacks
    from rig.calibration.session import conclude, read_instruments, recorded
    from rig.calibration.store import check_ours, check_writable
    from rig.run_facts import RunStatus

    backend, folders = backend_of(options["on"]), list(options["earlier"])
    files = FilesOffered(options["views"], options["board"], backend.is_simulated, options["out"])
    try:
        held = Recording.of(folders).names if folders else ()
        excitation = procedure.excite(profile, held)
    except RigLacks as lack:
        click.echo(f"{procedure.name}: {lack}", err=True)
        return 0 if options["every"] else 3  # the others do not need it
    try:
        for sentence in preview(procedure, profile, excitation, files, search[0]):
            click.echo(sentence, err=True)
        if options["readings"] is not None:  # what is wrong with it is said before anything moves
            read_instruments(
                procedure, profile, folders,
                simulated=backend.is_simulated, readings=options["readings"],
            )  # fmt: skip
        if options["dry_run"]:
            return 0
        check_writable(search[0], profile.name)
        if not options["replace"]:
            check_ours(profile, procedure.targets(profile))
        if excitation is None:  # nothing moves, so nobody is asked
            folders = []
            data, folder = procedure.read_files(profile, files)
        else:
            moves, warned = bool(excitation.motion.segments), options.setdefault("warned", set())
            if backend is Backend.HARDWARE:
                _refuse_unfit(profile, search, warned, moves=moves)
            if not _agreed(profile, backend, options["yes"]):
                return 2
            result, folders = _record(procedure, profile, backend, options)
            if result is not None and result.status is not RunStatus.OK:
                return _tell_ended(procedure, profile, result, folders)
        asks = partial(click.prompt, err=True)
        readings = read_instruments(
            procedure, profile, folders,
            simulated=backend.is_simulated, readings=options["readings"],
            prompt=None if options["yes"] is not None or not is_terminal(sys.stdin) else asks,
        )  # fmt: skip
        if excitation is not None:
            data, folder = recorded(folders), folders[-1]
        calibrated = conclude(
            procedure, profile, data, folder, readings,
            _circumstances(options, profile, _measured_on(folders, backend)), search,
            replace=options["replace"],
        )  # fmt: skip
    except NoFiles as lack:
        click.echo(str(lack), err=True)
        return 0
    except CalibrationRefused as refusal:
        return _tell_refused(procedure, profile, refusal, folders)
    except KeyboardInterrupt:
        if not (again := _going_on(procedure, profile, folders)):
            raise
        click.echo(f"interrupted; what was recorded is kept, go on with: {again}", err=True)
        return 130
    loops = _loops(profile, search, options, calibrated)
    done.append(as_data(procedure, calibrated, loops))
    show_found(procedure, calibrated, quiet=options["as_json"])
    known.update(loops)
    return 0


def _tell_loops(profile: Profile, loops: dict[str, ClosedLoop], *, quiet: bool) -> None:
    """Show once, after all procedures, how far the loops are from instability now."""
    tables, sentences = loops_of(profile, loops)
    if not quiet:
        print_tables(tables)
    for sentence in sentences:
        click.echo(sentence, err=True)


def _record(
    procedure: AnyProcedure, profile: Profile, backend: Backend, options: dict[str, Any]
) -> tuple[Result | None, list[Path]]:
    from rig.assembly import Backend
    from rig.calibration.session import record
    from rig.cli.progress import ProgressLine

    on: str = options["on"]
    with ProgressLine(f"calibrate {procedure.name}", on) as line:
        return record(
            procedure, profile, backend, options["out"],
            on=None if on in list(Backend) else on, earlier=options["earlier"], watcher=line,
            place=None if backend.is_simulated else _Placing(asks=options["yes"] is None),
            uncommissioned=options["uncommissioned"],
        )  # fmt: skip


_KEPT = ("on", "seed", "overrides", "out", "configs", "readings", "uncommissioned", "replace")
"""Options with which a procedure goes on as it began; `--yes` is asked anew."""


def _again(procedure: AnyProcedure, profile: Profile, folders: Sequence[Path]) -> str:
    """Return the command that goes on from recorded runs, as a shell takes it."""
    earlier = [word for folder in folders for word in ("--from", str(folder))]
    words = shlex.join([procedure.name, *given_options(_KEPT), *earlier])
    return f"rig calibrate {profile.argument} {words}"


def _going_on(procedure: AnyProcedure, profile: Profile, folders: Sequence[Path]) -> str:
    """Return the command that goes on from what was recorded; empty: nothing was."""
    from rig.calibration.recording import with_cycles

    kept = with_cycles(folders)
    return _again(procedure, profile, kept) if kept else ""


def _tell_ended(
    procedure: AnyProcedure,
    profile: Profile,
    result: Result,
    folders: Sequence[Path],
) -> int:
    click.echo(f"{result.status}: {result.message}", err=True)
    again = _going_on(procedure, profile, folders)
    kept = f"what was recorded is kept, go on with: {again}" if again else "nothing was recorded"
    click.echo(f"nothing was changed; {kept}", err=True)
    return result.exit_code


def _tell_refused(
    procedure: AnyProcedure,
    profile: Profile,
    refusal: Exception,
    folders: Sequence[Path],
) -> int:
    click.echo(f"{procedure.name}: {refusal}", err=True)
    click.echo("nothing was changed: the calibration before stays in force", err=True)
    if again := _going_on(procedure, profile, folders):
        click.echo(
            f"what was recorded is kept; if something is missing, go on with: {again}", err=True
        )
    return 1


def _measured_on(folders: Sequence[Path], backend: Backend) -> str:
    """Return where runs were recorded; a recording of long ago is not what `--on` says now."""
    from rig.calibration.store import origin_of
    from rig.run_folder import RunFolder

    backends = [RunFolder.open(path).manifest.get("backend", "") for path in folders]
    return origin_of(backends or [backend.value])


def _circumstances(options: dict[str, Any], profile: Profile, measured_on: str) -> Circumstances:
    from rig.assembly import Backend
    from rig.calibration.store import Circumstances

    said = {"temperature": options["temperature"], "supply pressure": options["supply"]}
    return Circumstances(
        options["operator"] or getpass.getuser(),
        options["valid_for"] * _DAY,
        {key: value for key, value in said.items() if value is not None},
        datetime.now(UTC),
        measured_on,
        None if measured_on == Backend.HARDWARE else profile.simulation.seed,
    )


class _Placing:
    """Has somebody put by hand what is to be measured; without anybody, the first is in place."""

    def __init__(self, *, asks: bool) -> None:
        self._asks = asks and is_terminal(sys.stdin)
        self._count = 0

    def __call__(self, what: str) -> bool:
        self._count += 1
        click.echo(what, err=True)
        if self._asks:
            return click.confirm("Is it there?", default=False, err=True)
        return self._count == 1


def _refuse_unfit(
    profile: Profile, search: Sequence[Path], warned: set[str], *, moves: bool
) -> None:
    """Refuse hardware that must not move; else warn as `rig check` does, once in a command."""
    from rig.assembly import check_fitness
    from rig.cli.check_warnings import tell_warnings
    from rig.experiment.fault_latch import FaultLatch

    FaultLatch.of(profile).check()
    if moves:
        check_fitness(profile)
    tell_warnings(profile, search, warned)


def _agreed(profile: Profile, backend: Backend, yes: str | None) -> bool:
    from rig.assembly import Backend
    from rig.cli.confirm import confirm
    from rig.hal import ConfigurationError

    if backend is Backend.HARDWARE:
        return confirm(profile.name, yes)
    if yes is not None:
        return True
    if not is_terminal(sys.stdin):
        raise ConfigurationError(
            "there is no terminal to ask: say --yes, or look first with --dry-run"
        )
    return click.confirm("Go?", default=False, err=True)


def _loops(
    profile: Profile, search: Sequence[Path], options: dict[str, Any], done: Calibrated
) -> dict[str, ClosedLoop]:
    """Return the loops of the rig as they are now that its mechanism is known better, if it is."""
    from rig.assembly import REGISTRY
    from rig.config import load_profile

    if all(finding.target != profile.mechanism for finding in done.findings):
        return {}
    return known_loops(load_profile(profile.files[0], REGISTRY, options["overrides"], search))
