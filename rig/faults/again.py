"""A case once more, from the folder that it left."""

from dataclasses import replace
from pathlib import Path

from rig.faults.campaign import run_cases
from rig.faults.case import Case, Moment
from rig.faults.survey import survey
from rig.faults.verdict import Verdict
from rig.hal import ConfigurationError
from rig.replaying.recorded import EXPERIMENT, PROFILE
from rig.run_folder import make_unique


def perform_again(case: Case, folder: Path, out: Path) -> Verdict:
    """Do to the rig of a run's folder what was done to it, and judge anew.

    Parameters
    ----------
    case : Case
        Of the folder.
    folder : Path
        Has the profile and the experiment that are run.
    out : Path
        Where the new run folder goes, in a folder of its own.

    Raises
    ------
    ConfigurationError
        What was run cannot be told from the folder alone.
    """
    if case.moment is Moment.CALIBRATION:
        raise ConfigurationError(
            f"{folder} is of a calibration, which a folder does not tell whole: repeat it with: "
            f"{case.command}"
        )
    here = folder.resolve()
    profile, experiment = str(here / PROFILE), str(here / EXPERIMENT)
    subject = survey(profile, (experiment,), None)
    same = replace(case, rig=profile, experiment=experiment, again=case.command, configs="")
    try:
        place = make_unique(out, f"{folder.name}-again")
    except OSError as error:
        raise ConfigurationError(f"cannot make a folder in {out}: {error}") from error
    (verdict,) = run_cases([(same, subject)], place, None, 1, lambda _: None, keeps=True)
    return verdict
