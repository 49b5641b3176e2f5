"""`rig.run`, `rig.load`, `rig.runs`: an experiment from Python, and what it left behind."""

import contextlib
import json
import sys
from collections.abc import Callable, Iterator, Mapping
from itertools import compress
from pathlib import Path

import numpy as np

from rig.assembly import Backend, backend_of
from rig.config.setting import Setting
from rig.experiment.ending import EXIT_BUG
from rig.experiment.pacing import PacedWatcher
from rig.experiment.plan import Plan, load_plan
from rig.experiment.run import run_experiment
from rig.experiment.watcher import Watcher
from rig.hal import ConfigurationError
from rig.hal.fits import shown
from rig.run_names import RUNS, find_run, list_runs_within
from rig.run_query import Candidate, choose
from rig.runtime.stop import StopRequests
from rig.scripting.errors import CodeFailed, MeasureFailed, error_of
from rig.scripting.given import MOST, Given, naming_theirs
from rig.scripting.played import PlanFunction, refuse_within_plan
from rig.scripting.recorded import Run
from rig.terminals import is_terminal

Settings = Mapping[str, object]
"""Settings by their dotted names, as ``--set`` takes them: numbers in SI, or text with a unit."""


def run(
    experiment: str | Path,
    *,
    on: str = "virtual",
    set: Settings | None = None,
    seed: int | None = None,
    pace: float | None = None,
    rig: str | None = None,
    controller: object | None = None,
    reference: object | None = None,
    plan: PlanFunction | None = None,
    measures: Mapping[str, object] | None = None,
    most: float = MOST,
    out: str | Path = "runs",
    configs: str | Path | None = None,
    frames: str | None = None,
    report: bool = False,
    strict: bool = False,
    yes: str | None = None,
    progress: bool | None = None,
    stop: StopRequests | None = None,
) -> Run:
    """Run an experiment, and return what was recorded.

    The same checks, limits and stops hold as on the command line. Ctrl-C stops the rig in an
    orderly way, a second one at once.

    Parameters
    ----------
    experiment : str or Path
        A name from ``rig list``, or the path of a YAML file.
    on : str
        ``sim``, ``virtual``, ``vcan``, ``hardware`` or an interface, as ``rig run --on``.
    set : mapping, optional
        Settings of the experiment or its rig: ``{"reference.amplitude": "4 mm"}``.
    seed : int, optional
        Of the simulation.
    pace : float, optional
        Times real time that a simulation goes at most, as ``rig run --pace``. None: as fast as
        it can, and in real time where somebody steers the motion.
    rig : str, optional
        Another rig than the experiment's.
    controller : str or object, optional
        Another controller of the profile by its name; or one in Python, see `Given`.
    reference, plan, measures : optional
        Python objects in the place of what the experiment names, see `Given`.
    most : float
        A plan that takes longer is a fault, s.
    out : Path
        Where run folders live.
    configs : Path, optional
        The folder of the configurations.
    frames : str, optional
        Record the CAN buses: ``"log"``, ``"asc"`` or ``"blf"``.
    report : bool
        Draw all figures and the page now; `Run.figure` and `Run.report` do it when asked for.
    strict : bool
        A bound that is missed is an exception, too.
    yes : str, optional
        The rig's name: hardware moves without asking at the terminal.
    progress : bool, optional
        Show the progress line; default: on a terminal.
    stop : StopRequests, optional
        ``rig.StopRequests()``, whose `request` stops the run from another thread, where no
        Ctrl-C arrives.

    Raises
    ------
    ConfigurationError
        A file, a setting, an object or the motion cannot be; nothing was opened.
    CodeFailed, NotEnergised, RunFaulted, RunInterrupted, BoundMissed, MeasureFailed
        How the run ended; each has it as `run`. All are `RunError`.
    DeviceError
        Hardware was refused before there was a run.
    """
    refuse_within_plan("rig.run")
    if not isinstance(experiment, str | Path) or not isinstance(on, str):
        raise ConfigurationError(
            f"experiment and on are {experiment!r} and {on!r}: names, or the path of a file"
        )
    options: list[str] = [*as_options(set)]
    if isinstance(controller, str):
        options.append(Setting(f"controller={controller}", f"controller={controller!r}"))
        controller = None
    if seed is not None:
        options.append(Setting(f"simulation.seed={seed}", f"seed={seed!r}"))
    backend = backend_of(on)
    loaded = load_plan(experiment, options, rig=rig, configs=_path(configs))
    given = Given(reference, plan, controller, measures)
    with naming_theirs():
        checked = given.applied(loaded, rehearse=backend is not Backend.SIM, most=most)
    _ask(checked, on, yes)
    if rig is not None:
        options.append(f"rig={rig}")
    is_number = isinstance(pace, int | float) and not isinstance(pace, bool)
    if pace is not None and not (is_number and 0.01 <= pace < float("inf")):
        raise ConfigurationError(f"pace is {pace!r}: a number, at least 0.01 times real time")
    pace = pace or (1.0 if checked.motion.real_time else None)
    if not backend.is_simulated:
        pace = None
    with naming_theirs(), _shown(checked, on, progress, pace) as watcher:
        result = run_experiment(
            checked, backend, Path(out),
            on=None if on in list(Backend) else on, overrides=options, watcher=watcher,
            report=report, frames=frames, stop=stop, raises=False,
        )  # fmt: skip
    recorded = Run(result.path)
    if result.bug is not None:
        if result.exit_code == EXIT_BUG:
            raise result.bug
        raise CodeFailed(recorded) from result.bug
    if result.unmeasured:
        what = "; ".join(str(error) for error in result.unmeasured)
        raise MeasureFailed(recorded, what) from result.unmeasured[0]
    error = error_of(recorded, result.exit_code, strict=strict)
    if error is not None:
        raise error
    return recorded


def load(run: str | Path, out: str | Path = RUNS) -> Run:
    """Return a recorded run.

    Parameters
    ----------
    run : str or Path
        Its folder, the name of one in `out`, or ``"latest"``.
    out : Path
        Where run folders live.

    Raises
    ------
    ConfigurationError
        It is no run folder.
    """
    return Run(find_run(str(run), Path(out)))


def runs(out: str | Path = "runs", where: str | Callable[[Run], bool] | None = None) -> list[Run]:
    """Return recorded runs, the newest first.

    Parameters
    ----------
    out : Path
        Where run folders live, or folders of them, as those of a campaign.
    where : str or callable, optional
        ``"marker_rms < 0.2 mm and rig = joint"``, as for ``rig list runs --where``; or
        ``where(run)``: whether it is wanted.

    Raises
    ------
    ConfigurationError
        `where` asks for what no run has.
    """
    if not (where is None or isinstance(where, str) or callable(where)):
        raise ConfigurationError(f"where is {where!r}, and neither a text nor a function of a run")
    found = []
    for path in list_runs_within(Path(out)):
        try:
            one = Run(path)
        except ConfigurationError:
            continue  # a manifest that is torn is no run that could be looked at
        found.append(one)
    if isinstance(where, str):
        return list(compress(found, choose(where, [_candidate(one) for one in found])))
    return found if where is None else [one for one in found if where(one)]


def _candidate(run: Run) -> Candidate:
    try:
        metrics = {name: (metric.value, metric.unit) for name, metric in run.metrics.items()}
    except ConfigurationError:  # nothing is known of it
        metrics = {}
    return Candidate({**run.manifest, "name": run.path.name}, metrics)


def as_options(settings: Settings | None) -> list[Setting]:
    """Return settings as the options of the command line.

    Raises
    ------
    ConfigurationError
        They are no mapping of dotted names.
    """
    if settings is not None and not isinstance(settings, Mapping):
        raise ConfigurationError(f"set is {settings!r}, and no mapping of settings to values")
    return [
        Setting(f"{key}={_as_text(value)}", f"set={{{key!r}: {shown(value)}}}")
        for key, value in (settings or {}).items()
    ]


def _as_text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, np.generic | np.ndarray):
        return _as_text(value.tolist())
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_as_text(item) for item in value)}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {_quoted(item)}' for key, item in value.items())}}}"
    return "null" if value is None else str(value)


def _quoted(value: object) -> str:
    """Return a value of a mapping, whose words may hold a comma or a brace."""
    return json.dumps(value) if isinstance(value, str) else _as_text(value)


def _path(path: str | Path | None) -> Path | None:
    return None if path is None else Path(path)


def _ask(plan: Plan, on: str, yes: str | None) -> None:
    """Say what hardware will do, and have somebody type the rig's name.

    Raises
    ------
    ConfigurationError
        Nobody has.
    """
    from rig.cli.announce import may_move
    from rig.cli.confirm import NotConfirmed

    with contextlib.suppress(NotConfirmed):
        if may_move(plan, on, yes):
            return
    name = plan.profile.name
    raise ConfigurationError(f"nothing was moved: give the rig's name, yes={name!r}")


@contextlib.contextmanager
def _shown(plan: Plan, on: str, progress: bool | None, pace: float | None) -> Iterator[Watcher]:
    """Yield who tells of the run as it goes on."""
    from rig.cli.watched_run import WatchedRun

    if progress is None:
        progress = is_terminal(sys.stderr)
    if not progress:
        yield Watcher() if pace is None else PacedWatcher(pace)
        return
    with WatchedRun(plan, on, needs_hold=False, pace=pace) as line:
        yield line
