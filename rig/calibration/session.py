"""A procedure on a rig, from the recording to the calibration file."""

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from rig.assembly import Backend, check_profile
from rig.assembly.answers import check_motion
from rig.calibration import instruments, store
from rig.calibration.basis import basis_of
from rig.calibration.check_findings import check_findings
from rig.calibration.instrument_files import read_file
from rig.calibration.instruments import Readings
from rig.calibration.page import draw_page
from rig.calibration.procedure import AnyProcedure, Data, Excitation, Finding, Procedure
from rig.calibration.recording import CalibrationRefused, Recording
from rig.commissioning.permission import refuse_uncommissioned
from rig.config import (
    Experiment,
    Profile,
    ProfileError,
    ReferenceEntry,
    SimulationSettings,
    format_quantity,
)
from rig.experiment.plan import Plan
from rig.experiment.run import Result, run_experiment
from rig.experiment.watcher import Watcher
from rig.installation import need
from rig.run_facts import FIGURES, RunStatus


class Calibrated(NamedTuple):
    """The result of a procedure: findings, and the files that were written.

    Parameters
    ----------
    findings : sequence of Finding
        What was found.
    files : sequence of Path
        The calibration files that were written.
    figures : sequence of Path
        The page.
    """

    findings: Sequence[Finding]
    files: Sequence[Path]
    figures: Sequence[Path]

    def __repr__(self) -> str:
        found = [
            f"{finding.target} {estimate.name}: {format_quantity(estimate.value, estimate.unit)} "
            f"({format_quantity(estimate.low, estimate.unit)} to "
            f"{format_quantity(estimate.high, estimate.unit)}, 95 %)"
            for finding in self.findings
            for estimate in finding.estimates
        ]
        return "\n".join([*found, *map(str, self.files)])


def plan_of(procedure: AnyProcedure, excitation: Excitation) -> Plan:
    """Return an excitation as what the runtime runs."""
    check_profile(excitation.profile)
    what = f"the motion of the procedure {procedure.name}"
    check_motion(what, excitation.motion, excitation.profile.loop.period)
    kind = type(excitation.settings).__name__.lower()
    experiment = Experiment(
        name=f"calibrate-{procedure.name}",
        description=procedure.title,
        rig=excitation.profile.name,
        controller=excitation.controller_name,
        reference=ReferenceEntry(kind, excitation.settings),
        approach=excitation.approach,
        metrics={},
        figures=(),
    )
    return Plan(experiment, excitation.profile, excitation.controller, excitation.motion)


def record(
    procedure: AnyProcedure,
    profile: Profile,
    backend: Backend,
    out: Path,
    *,
    on: str | None = None,
    earlier: Sequence[Path] = (),
    watcher: Watcher | None = None,
    place: Callable[[str], bool] | None = None,
    uncommissioned: str | None = None,
) -> tuple[Result | None, list[Path]]:
    """Record what is not recorded yet.

    Parameters
    ----------
    procedure, profile, backend, out, on, watcher
        See `rig.experiment.run.run_experiment`.
    earlier : sequence of Path
        Runs of the same procedure that were ended before their time: what they hold is kept.
    place : callable, optional
        Told before each run what somebody has to put where by hand; returns whether it is there.
        Without it everything is taken to be in its place.
    uncommissioned : str, optional
        Why hardware that is not commissioned is moved all the same.

    Returns
    -------
    result : Result or None
        How it ended; None if nothing was left to record.
    folders : list of Path
        All run folders, the new ones last.
    """
    need("matplotlib", "scipy")  # for what comes of it
    result, folders = None, list(earlier)
    if backend is Backend.HARDWARE:
        uncommissioned = refuse_uncommissioned(profile, uncommissioned)
    done = Recording.of(earlier).names if earlier else ()
    while True:
        excitation = procedure.excite(profile, done)
        if excitation is None or not excitation.motion.segments:
            return result, folders
        if excitation.placing and place is not None and not place(excitation.placing):
            return result, folders
        result = run_experiment(
            plan_of(procedure, excitation), backend, out,
            on=on, watcher=watcher, report=False, heed_calibrations=False,
            uncommissioned=uncommissioned,
        )  # fmt: skip
        folders.append(result.path)
        # What is placed by hand comes run by run, as long as each one gets somewhere.
        if not excitation.placing or result.status is not RunStatus.OK:
            return result, folders
        before, done = done, Recording.of(folders).names
        if len(done) == len(before):
            return result, folders


def read_instruments(
    procedure: AnyProcedure,
    profile: Profile,
    folders: Sequence[Path],
    *,
    simulated: bool,
    readings: Path | None = None,
    prompt: Callable[[str], str] | None = None,
) -> Readings:
    """Return what the procedure's reference instruments showed.

    Raises
    ------
    CalibrationRefused
        Nobody is there to read them; says how to hand the readings over later.
    """
    wanted = procedure.instruments(profile)
    if not wanted:
        return {}
    if readings is not None:
        return read_file(wanted, readings)
    if simulated:
        return instruments.simulate(wanted, folders, profile.simulation.seed)
    read = [instrument for instrument in wanted if not instrument.expected]
    if not read:
        return instruments.made_to(wanted)
    if prompt is None:
        names = ", ".join(instrument.name for instrument in read)
        runs = " ".join(f"--from {path}" for path in folders)
        raise CalibrationRefused(
            f"nobody is there to read {names}; write quantity,stretch,value lines to a file and "
            f"go on with: rig calibrate {profile.argument} {procedure.name} {runs} --readings FILE"
        )
    return instruments.ask(wanted, prompt)


def recorded(folders: Sequence[Path]) -> Recording:
    """Return what run folders hold.

    Raises
    ------
    CalibrationRefused
        No stretch was recorded to its end.
    """
    recording = Recording.of(folders)
    if not recording.names:
        raise CalibrationRefused("nothing was recorded to its end")
    return recording


def conclude(
    procedure: Procedure[Data],
    profile: Profile,
    data: Data,
    folder: Path,
    readings: Readings,
    circumstances: store.Circumstances,
    search: Sequence[Path],
    *,
    replace: bool = False,
) -> Calibrated:
    """Identify, draw the page and write the files.

    Parameters
    ----------
    procedure, profile
        What was done on what.
    data : Evidence
        What it rests on.
    folder : Path
        The run folder that the page goes to.
    readings : mapping
        Of the reference instruments.
    circumstances : Circumstances
        For the files.
    search : sequence of Path
        The configuration folders; the files are written into the first.
    replace : bool
        Replace a better or an unreadable calibration.

    Raises
    ------
    CalibrationRefused
        The data do not suffice, or the fit is worse than the one in force. The page is drawn
        whenever there is a fit.
    ContractBroken
        The profile's settings do not take what was found; nothing is drawn or written.
    """
    # What is true of a simulated rig, and how it is drawn, is no business of an identification.
    seen = dataclasses.replace(profile, simulation=SimulationSettings(), plant=None)
    findings, name = procedure.identify(seen, data, readings), procedure.name
    check_findings(procedure, findings, profile)
    if not replace:
        store.check_ours(profile, [finding.target for finding in findings])
    figures = draw_page(folder / FIGURES, f"calibration-{name}", findings, circumstances.origin)
    files = []
    contents = []
    for finding in findings:
        try:
            old = store.in_force(profile, search, finding.target)
        except ProfileError:
            if not replace:
                raise
            old = None  # what nobody can trust is replaced; its history stays
        if not replace:
            store.check_not_worse(finding, name, old)
        basis = basis_of(
            profile, finding.target, with_dimensions=procedure.rests_on_dimensions
        )  # fmt: skip
        contents.append(
            store.compose(finding, name, profile, data, circumstances, old, search, basis)
        )
    for finding, content in zip(findings, contents, strict=True):
        files.append(store.write(search[0], profile.name, finding.target, content))
    return Calibrated(findings, files, figures)
