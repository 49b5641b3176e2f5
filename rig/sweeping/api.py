"""A sweep from Python."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from rig.scripting.played import refuse_within_plan
from rig.sweeping.arguments import check_arguments
from rig.sweeping.progress import SweepProgress
from rig.sweeping.request import SweepRequest, as_options
from rig.sweeping.result import Sweep, SweepEnd, SweepInterrupted
from rig.sweeping.run import run_sweep
from rig.sweeping.stop_rule import parse_budget, parse_stop_rule
from rig.sweeping.sweep_file import axes_of, seeds_of
from rig.sweeping.written import in_python


def sweep(
    experiment: str | Path,
    vary: Mapping[str, str | Sequence[object]] | None = None,
    *,
    seeds: str | Sequence[int] | None = None,
    on: str = "virtual",
    rig: str | None = None,
    set: Mapping[str, object] | None = None,
    workers: int | None = None,
    dask: str | None = None,
    out: str | Path | None = None,
    configs: str | Path | None = None,
    stop_when: str | None = None,
    budget: str | None = None,
    metric: str | None = None,
    keep: int = 3,
    draw_seed: int = 0,
    quiet: bool = False,
) -> Sweep:
    """Run an experiment under many settings; what is finished is never run again.

    Parameters
    ----------
    experiment : str or Path
        A name, or the path of a file.
    vary : mapping, optional
        Settings with their values: a list, or a text such as ``"1..5:9"``, ``"log:1..100:5"`` or
        ``"uniform:0..1:50"``.
    seeds : sequence of int or str, optional
        Seeds of the simulation: ``range(20)`` or ``"0:20"``.
    on : str
        ``"sim"`` or ``"virtual"``.
    rig : str, optional
        Another rig than the experiment's.
    set : mapping, optional
        Settings of every point.
    workers : int, optional
        Points at once; default: one for each processor.
    dask : str, optional
        The address of a Dask scheduler, or its file, in the place of workers of this machine.
    out : str or Path, optional
        The sweep's folder; default: ``runs/sweeps/EXPERIMENT-BACKEND``.
    configs : str or Path, optional
        The folder of the configurations.
    stop_when : str, optional
        End with the first point of which this is true: ``"marker_rms < 0.2 mm"``.
    budget : str, optional
        Begin no point after ``"30 min"``, or ``"500 points"``.
    metric : str, optional
        What the best points are best in; default: the first metric.
    keep : int
        Of so many of the best points the run folder is kept, and of those that failed; -1: of all.
    draw_seed : int
        Of axes that are drawn.
    quiet : bool
        Say nothing on the standard error.

    Returns
    -------
    Sweep
        With ``table``, ``best(metric)`` and ``figure(metric)``; ``complete`` is False if the budget
        or `stop_when` ended it.

    Raises
    ------
    ConfigurationError
        What was asked cannot be done, found before any point runs.
    SweepInterrupted
        Ctrl-C; the points that are finished are its ``sweep``. It is a `KeyboardInterrupt`.
    DeviceError
        Another sweep works in the folder, the disk is full, or the cluster has gone; what is
        finished is kept.
    """
    check_arguments(locals())
    refuse_within_plan("rig.sweep")
    seconds, points = parse_budget(budget) if budget is not None else (None, None)
    request = SweepRequest(
        experiment=str(experiment),
        axes=axes_of(vary or {}, in_python),
        seeds=None if seeds is None else seeds_of(seeds),
        on=on,
        options=as_options(set or {}, in_python),
        rig=rig,
        configs=None if configs is None else Path(configs),
        workers=workers or 0,
        dask=dask,
        out=None if out is None else Path(out),
        draw_seed=draw_seed,
        stop_when=None if stop_when is None else parse_stop_rule(stop_when),
        seconds=seconds,
        points=points,
        best=metric,
        keep=keep,
    )
    found = run_sweep(request, lambda total: SweepProgress(total, quiet=quiet))
    if found.end is SweepEnd.INTERRUPTED:
        raise SweepInterrupted(found)
    return found
