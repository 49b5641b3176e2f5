"""One sweep, from what was asked to its table, figure and page."""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

from rig.assembly import REGISTRY, Backend
from rig.config import Experiment, ProfileError, find_configs
from rig.config.diagnostics import nearest
from rig.config.experiment import rig_of
from rig.config.names import is_path
from rig.experiment.permission import check_permitted
from rig.experiment.plan import make_plan
from rig.hal import ConfigurationError
from rig.installation import need
from rig.sweeping.axis import Axis
from rig.sweeping.best import Best
from rig.sweeping.code import CodeVersion, code_version
from rig.sweeping.coordinator import Coordinator, Limits, Task
from rig.sweeping.dask_cluster import DaskCluster
from rig.sweeping.design import Design, make_design
from rig.sweeping.engine import PERFORM, Engine, WorkerSetup
from rig.sweeping.errors import SweepStopped
from rig.sweeping.finding import PointFinding
from rig.sweeping.journal import Journal
from rig.sweeping.page import draw, remove_drawn
from rig.sweeping.point import PointJob, reason_of
from rig.sweeping.pool import Pool
from rig.sweeping.progress import SweepProgress
from rig.sweeping.request import SweepRequest
from rig.sweeping.result import Sweep, SweepEnd, SweepRows, write_sweep
from rig.sweeping.serial import Serial
from rig.sweeping.source import PointSource, freeze_configs, name_unresolved, resolve
from rig.sweeping.variations import Variations

LOGS = "runs"
_CONFIGS = ".configs"


def run_sweep(
    request: SweepRequest, progress: Callable[[int], SweepProgress], perform: str = PERFORM
) -> Sweep:
    """Run what is not finished of a sweep, and write its table.

    Parameters
    ----------
    request : SweepRequest
        What is asked.
    progress : callable
        Makes what is told of it, from the number of points.
    perform : str
        What runs a point, ``"module:function"``.

    Returns
    -------
    Sweep
        Of the points that are finished; Ctrl-C leaves a part of them.

    Raises
    ------
    ConfigurationError
        What was asked cannot be done, found before any point runs.
    SweepStopped
        Another sweep works in the folder, or points cannot be run any more; the table of what
        is finished is written.
    ModuleNotFoundError
        What draws its figure is not installed.
    """
    need("matplotlib")
    request = request.checked()
    design = make_design(request.axes, request.seeds, request.draw_seed)
    with closing(Journal(request.folder)) as journal:
        code = code_version()
        configs = request.folder.resolve() / _CONFIGS
        logs = request.folder.resolve() / LOGS
        setup = WorkerSetup(perform, code.digest, request.folder.resolve() / "workers.log")
        with journal.provisional(configs):
            source = _checked_source(request, design, configs, code)
            shown = progress(design.count)
            opened = _engine(request, setup, configs, shown.say)
        with closing(opened) as engine:
            best = Best(request.best, request.keep, logs)
            coordinator = Coordinator(journal, engine, shown, _limits(request), best)
            end, trouble = SweepEnd.DONE, None
            try:
                coordinator.run(_tasks(source, design, configs, logs))
            except KeyboardInterrupt:
                end = SweepEnd.INTERRUPTED
                shown.say("interrupted: no run goes on; writing the table …")
                journal.read()
            except SweepStopped as error:
                trouble = error
            if coordinator.cut:
                end = SweepEnd.BUDGET
        shown.clear()
        _remove_unfinished(logs)
        sweep = write_sweep(request.folder, SweepRows(design, coordinator, journal), end, shown.say)
        if end is SweepEnd.INTERRUPTED:  # who presses Ctrl-C does not wait for a figure
            remove_drawn(request.folder)
        else:
            title = f"{source.experiment} on {request.on}, {len(sweep.data.points)} points"
            draw(sweep, request.best, title, shown.say)
            _tell_of_edits(code, shown)
        if trouble is not None:
            raise trouble
        return sweep


def _checked_source(
    request: SweepRequest, design: Design, configs: Path, code: CodeVersion
) -> PointSource:
    """Copy the configurations; return where points come from, after a look at all of the axes."""
    name = freeze_configs(request.experiment, request.configs, configs)
    options = (*_rig_by_path(request), *request.options)
    source = PointSource(
        name, options, request.rig, request.on, code.digest, request.uncommissioned
    )
    check_axes(source, design, configs)
    first = resolve(source, design.options(0), configs)
    _check_metrics(request, first.experiment, first.profile.mechanism)
    if request.serial:
        _preflight(source, design, configs)
    return source


def _rig_by_path(request: SweepRequest) -> tuple[str, ...]:
    """Return the rig as an option if the experiment names it by its path: the copy is elsewhere."""
    own = rig_of(request.experiment, find_configs(request.configs))
    return (f"rig={json.dumps(str(Path(own).resolve()))}",) if own and is_path(own) else ()


def _tell_of_edits(code: CodeVersion, shown: SweepProgress) -> None:
    changed = code.changed(code_version())
    if changed:
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        shown.say(f"the source changed meanwhile ({changed[0]}{more}); all points ran as it was")


def check_axes(source: PointSource, design: Design, configs: Path) -> None:
    """Check each value of each axis beside the first values of the others.

    Raises
    ------
    ConfigurationError
        A setting does not exist, or a value is not one of it.
    """
    first = design.texts(0)
    resolve(source, design.options_of(first), configs)
    for place, axis in enumerate(design.axes):
        for text in _telling(axis):
            texts = (*first[:place], text, *first[place + 1 :])
            try:
                resolve(source, design.options_of(texts), configs)
            except ProfileError as error:
                said = [option.written for option in axis.options(text)]
                if any(option in str(error) for option in said):
                    raise
                raise ConfigurationError(f"{', '.join(said)}: {reason_of(error)}") from error


def _check_metrics(request: SweepRequest, experiment: Experiment, mechanism: str) -> None:
    """Refuse a metric that no run of the experiment has; bounds may be of it or of ``.min``."""
    rule = request.stop_when
    known = (*experiment.metrics, *REGISTRY.reported(mechanism))
    for option, name in (("metric", request.best), ("stop when", rule and rule.metric)):
        if name is not None and name.removesuffix(".min") not in known:
            hint = nearest(name, known) or "it has none"
            raise ConfigurationError(f"{option}: {experiment.name} has no metric {name!r}; {hint}")


def _telling(axis: Axis | Variations) -> tuple[str, ...]:
    """Return the values that tell whether all can be: of many numbers the ends and some between."""
    count = len(axis.texts)
    if count <= 20 or isinstance(axis, Variations):
        return axis.texts
    return tuple(axis.texts[place] for place in (0, count // 2, count - 1))


def _tasks(source: PointSource, design: Design, configs: Path, logs: Path) -> Iterator[Task]:
    for number in range(design.count):
        options = design.options(number)
        try:
            name = resolve(source, options, configs).name
        except ConfigurationError as error:
            name = name_unresolved(source, options)
            yield PointFinding(point=name, status="refused", reason=reason_of(error), metrics=[])
        else:
            yield PointJob(name, source, options, configs, logs)


def _limits(request: SweepRequest) -> Limits:
    rule = request.stop_when
    return Limits(request.seconds, request.points, None if rule is None else rule.reached)


def _engine(
    request: SweepRequest, setup: WorkerSetup, configs: Path, say: Callable[[str], None]
) -> Engine:
    if request.serial:
        return Serial(request.cool_down, say)
    if request.dask is not None:
        return DaskCluster(request.dask, setup, configs)
    return Pool(request.workers or os.cpu_count() or 1, setup)


def _preflight(source: PointSource, design: Design, configs: Path) -> None:
    """Refuse a queue of runs any of which cannot be done, before the rig moves.

    Raises
    ------
    RigError
        One cannot be done or is not permitted; with its settings.
    """
    for number in range(design.count):
        options = design.options(number)
        resolved = resolve(source, options, configs)
        try:
            plan = make_plan(resolved.experiment, resolved.profile)
            check_permitted(plan, Backend(source.backend), heed_calibrations=True)
        except ConfigurationError as error:
            raise ConfigurationError(f"{' '.join(options)}: {error}") from error


def _remove_unfinished(logs: Path) -> None:
    """Remove the run folders of points that were under way."""
    for folder in logs.glob(".*") if logs.is_dir() else ():
        shutil.rmtree(folder, ignore_errors=True)
