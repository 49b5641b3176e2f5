"""Where the points of a sweep come from: an experiment, and configurations that stand still."""

import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY
from rig.config import Experiment, Profile, find_configs, load_experiment, load_profile
from rig.config.document import plain_under
from rig.config.dump import plain_of
from rig.config.experiment import rig_of
from rig.config.located import Plain
from rig.config.named_files import files_in
from rig.config.names import find_file, is_path
from rig.config.setting import Setting
from rig.experiment.plan import admit_options, split_overrides
from rig.hal import ConfigurationError
from rig.hal.files import is_file, open_regular

_LARGEST = 1 << 20
"""No configuration is larger, bytes."""


class PointSource(NamedTuple):
    """The part that all points of a sweep have in common.

    Parameters
    ----------
    experiment : str
        A name, or the path of a file.
    options : tuple of str
        Settings of every point, as for ``--set``.
    rig : str or None
        Another rig than the experiment's.
    backend : str
        What it runs on.
    code : str
        The version of the code.
    uncommissioned : str, optional
        See `SweepRequest`.
    """

    experiment: str
    options: tuple[str, ...]
    rig: str | None
    backend: str
    code: str
    uncommissioned: str | None = None


class Resolved(NamedTuple):
    """A point with every setting that it has.

    Parameters
    ----------
    name : str
        Says all that its result depends on: a hash of its settings and of the code.
    experiment, profile : Experiment, Profile
        As loaded.
    """

    name: str
    experiment: Experiment
    profile: Profile


def resolve(source: PointSource, options: Sequence[str], configs: Path) -> Resolved:
    """Load a point's experiment and profile, and name it by them.

    Raises
    ------
    ConfigurationError
        They are not valid.
    """
    search = find_configs(configs)
    rig = source.rig or rig_of(source.experiment, search)
    for_experiment, for_profile = split_overrides((*source.options, *options), rig, search)
    if source.rig is not None:
        for_experiment = [*for_experiment, Setting(f"rig={source.rig}", f"--rig {source.rig}")]
    admit_options(for_profile, rig, search)
    experiment = load_experiment(source.experiment, REGISTRY, for_experiment, search)
    profile = load_profile(experiment.rig, REGISTRY, for_profile, search)
    sheets = [
        hashlib.sha256(entry.eds.read_bytes()).hexdigest()
        for entry in profile.devices.values()
        if entry.eds is not None
    ]
    sheets += [
        hashlib.sha256(path.read_bytes()).hexdigest()
        for _, path in files_in(experiment.reference.settings)
    ]
    content = [source.code, source.backend, plain_of(experiment), plain_of(profile), sheets]
    text = json.dumps(content, sort_keys=True, ensure_ascii=False)
    return Resolved(hashlib.sha256(text.encode()).hexdigest()[:32], experiment, profile)


def name_unresolved(source: PointSource, options: Sequence[str]) -> str:
    """Return the name of a point whose settings cannot be resolved."""
    text = json.dumps([*source, *options], ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def freeze_configs(experiment: str, given: Path | None, into: Path) -> str:
    """Copy the configurations, so that what is edited from now on changes no point.

    Parameters
    ----------
    experiment : str
        A name, or the path of a file, which is copied with those beside it.
    given : Path, optional
        The folder of the configurations.
    into : Path
        A folder; what was there is removed.

    Returns
    -------
    str
        The experiment's name in the copy.

    Raises
    ------
    ConfigurationError
        There is no such experiment, or the copy cannot be written.
    """
    search = find_configs(given)
    path = find_file(experiment, "experiments", search)
    try:
        shutil.rmtree(into, ignore_errors=True)
        for folder in reversed([at for at in search if at.is_dir()]):  # earlier hides later
            shutil.copytree(
                folder, into, ignore=_too_large, copy_function=_copy, dirs_exist_ok=True
            )
        if is_path(experiment):
            beside = into / "experiments"
            beside.mkdir(parents=True, exist_ok=True)
            for file in {path, *path.parent.glob("*.yaml")}:
                shutil.copy(file, beside)
            _copy_named(path, beside, into)
    except (OSError, shutil.Error) as error:
        raise ConfigurationError(f"cannot copy the configurations to {into}: {error}") from error
    return path.stem


def _copy_named(experiment: Path, beside: Path, into: Path) -> None:
    """Copy the tables that an experiment's own file names to where its copy looks for them."""
    reference = plain_under("reference", experiment, "experiments")
    for named in _texts(reference):
        source = experiment.parent / named
        copy = Path(os.path.normpath(beside / named))
        if not Path(named).is_absolute() and copy.is_relative_to(into) and is_file(source):
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, copy)


def _texts(value: Plain) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _texts(item)


def _copy(source: str, target: str) -> None:
    open_regular(Path(source)).close()  # the copy's own error is that of all files, in one heap
    shutil.copy2(source, target)


def _too_large(folder: str, names: list[str]) -> list[str]:
    paths = [Path(folder, name) for name in names]
    return [p.name for p in paths if p.is_file() and p.stat().st_size > _LARGEST]
