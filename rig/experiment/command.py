"""The command line that runs an experiment again, in a fresh shell."""

from collections.abc import Sequence
from pathlib import Path

from rig.config import Experiment, find_configs
from rig.config.names import find_file
from rig.hal import ConfigurationError


def command_of(
    experiment: Experiment, on: str, overrides: Sequence[str], frames: str | None
) -> list[str]:
    """Return the words of the command.

    Parameters
    ----------
    experiment : Experiment
        As loaded.
    on : str
        A backend or CAN interfaces.
    overrides : sequence of str
        The options that shaped the plan.
    frames : str or None
        The format in which the buses were recorded, if they were.
    """
    command = ["rig", "run", *_source(experiment), "--on", on]
    for option in overrides:
        command += ["--set", option]
    if frames is not None:
        command.append(f"--frames={frames}")
    return command


def _source(experiment: Experiment) -> list[str]:
    """Return how the experiment is found: by its name, in its folder of configurations or by path.

    Paths are absolute: a fresh shell stands elsewhere.
    """
    if not experiment.files:
        return [experiment.name]
    path = Path(experiment.files[0]).resolve()
    try:
        if find_file(path.stem, "experiments", find_configs()[-1:]).resolve() == path:
            return [path.stem]
    except ConfigurationError:
        pass  # it is not one of those that come with the program
    if path.parent.name == "experiments":
        return [path.stem, "--configs", str(path.parent.parent)]
    return [str(path)]
