"""`rig.check`: whether a profile or an experiment is valid, and what it says."""

from pathlib import Path

from rig.scripting.running import Settings, as_options


def check(
    source: str | Path,
    *,
    set: Settings | None = None,
    configs: str | Path | None = None,
) -> dict[str, object]:
    """Return what a profile or an experiment says, as ``rig check --json`` prints it.

    Parameters
    ----------
    source : str or Path
        A name from ``rig list``, or the path of a YAML file.
    set : mapping, optional
        Settings by their dotted names.
    configs : Path, optional
        The folder of the configurations.

    Raises
    ------
    ConfigurationError
        It is not valid; with every error of the file, or why its motion cannot be.
    """
    from rig.assembly import check_channels
    from rig.cli.check import load
    from rig.cli.check_hardware import refusals_of, refusals_of_plan
    from rig.cli.check_warnings import warnings_of
    from rig.cli.description import (
        describe_experiment,
        describe_frozen,
        describe_profile,
    )
    from rig.cli.loops import describe_loop
    from rig.config.names import find_configs
    from rig.experiment.frozen import longest_freeze

    folder = None if configs is None else Path(configs)
    profile, plan = load(str(source), as_options(set), folder)
    check_channels(profile)
    described = dict(describe_profile(profile))
    warnings, refused = warnings_of(profile, find_configs(folder)), list(refusals_of(profile))
    if plan is None:
        return {**described, "warnings": warnings, "refused_on_hardware": refused}
    bound = longest_freeze(plan)
    experiment = {
        **describe_experiment(plan),
        "loop": describe_loop(plan),
        "frozen": describe_frozen(plan, bound),
    }
    return {
        "experiment": experiment,
        "profile": described,
        "warnings": warnings,
        "refused_on_hardware": [*refused, *refusals_of_plan(plan, bound)],
    }
