"""A run's folder as the run begins: profile, experiment and calibrations as they are used."""

from collections.abc import Sequence
from pathlib import Path

from rig.assembly import Backend, Rig
from rig.config import dump_resolved
from rig.config.device_file import text_of
from rig.config.dump import REFERENCE_FILES
from rig.config.named_files import copies_of, files_in
from rig.experiment.command import command_of
from rig.experiment.metrics import evaluation_as_json
from rig.experiment.plan import Plan, constants_of
from rig.hal import Column
from rig.run_facts import EVALUATION
from rig.run_folder import RunFolder
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS


def create_folder(
    plan: Plan,
    backend: Backend,
    on: str | None,
    out: Path,
    overrides: Sequence[str],
    frames: str | None,
    command: Sequence[str] = (),
) -> RunFolder:
    """Make the folder of a run, with what it is going to run.

    Parameters
    ----------
    plan, backend, on, out, overrides, frames, command
        See `rig.experiment.run.run_experiment`.

    Raises
    ------
    RunFolderError
        It cannot be made.
    """
    experiment, profile = plan.experiment, plan.profile
    calibrations = {
        f"calibration/{path.name}": path.read_text(encoding="utf-8")
        for path in profile.files
        if path.parent.parent.name == "calibration"
    }
    data_sheets = {
        f"eds/{name}.eds": text_of(entry.eds)
        for name, entry in profile.devices.items()
        if entry.eds is not None
    }
    settings = experiment.reference.settings
    kept = copies_of(settings, REFERENCE_FILES)
    motion = {kept[keys]: text_of(path) for keys, path in files_in(settings)}
    folder = RunFolder.create(
        out,
        experiment.name,
        backend.value,
        inputs={
            "profile.yaml": dump_resolved(profile),
            "experiment.yaml": dump_resolved(experiment),
            **calibrations,
            **data_sheets,
            **motion,
            **plan.sources,
        },
        seed=profile.simulation.seed if backend.is_simulated else None,
        command=command or command_of(experiment, on or backend.value, overrides, frames),
        rig=profile.name,
        law=experiment.controller,
    )
    write_evaluation(plan, folder)
    return folder


def write_evaluation(plan: Plan, folder: RunFolder) -> None:
    """Write what is needed beside the log to judge and draw a run."""
    experiment = plan.experiment
    content = evaluation_as_json(
        plan.motion.segments,
        experiment.metrics,
        experiment.figures,
        plan.motion.facts,
        plan.profile.mechanism,
        constants_of(plan.profile),
        plan.profile.additions,
        plan.motion.remarks,
    )
    folder.write_json(EVALUATION, content)


def log_columns(rig: Rig) -> tuple[Column, ...]:
    """Return what a row of the log holds, in the order of `rig.runtime.cycle.Cycle.note`."""
    measured = [column for device in rig.devices.values() for column in device.log_columns]
    run, timing = RUN_COLUMNS, TIMING_COLUMNS
    return (*run, *rig.mechanism.columns, *measured, *timing, *rig.truth_columns)
