"""The milestones of `rig status`, and those of loops: what is modelled, and what was measured."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypedDict

if TYPE_CHECKING:
    from rig.cli.listing import RunEntry
    from rig.config import Profile
    from rig.config.models import Calibration


class Milestone(NamedTuple):
    """One milestone on the way to a rig that tracks.

    Parameters
    ----------
    what : str
        Its name.
    state : str
        How far it has come.
    remedy : str
        The command that brings it further; empty: nothing is missing.
    better : str
        The command that may make it better, though nothing is missing.
    """

    what: str
    state: str
    remedy: str = ""
    better: str = ""


def margin_missed(law: str, calibration: Calibration, rig: str) -> tuple[str, str]:
    """Say how many drawn plants keep their margin, and what looks for better gains.

    Both are empty if as many do as `rig tune` asks for.
    """
    from rig.hal.closed_loop import SENSITIVITY
    from rig.tuning.verdict import ENOUGH

    conditions = calibration.provenance.conditions
    kept = conditions.get("sensitivity kept", "")
    share, _, plants = kept.partition(" % of ")
    if not share.replace(".", "", 1).isdecimal() or float(share) >= 100.0 * ENOUGH:
        return "", ""
    generations = conditions.get("generations", "")
    more = f" --generations {2 * int(generations)}" if generations.isdecimal() else ""
    experiment = conditions.get("tuned for", "")
    wanted = f" --for {shlex.quote(experiment)}" if experiment and " " not in experiment else ""
    count, _, measured = plants.partition(", ")
    return (
        f"; only {share} % of {count} keep a sensitivity of at most {SENSITIVITY:g}"
        f"{f' ({measured})' if measured else ''}, and {100.0 * ENOUGH:g} % are asked for",
        f"rig tune {rig} --controller {law}{wanted}{more}",
    )


def loops_of_rig(profile: Profile, out: Path) -> list[Milestone]:
    """Return how far each loop of a rig is from instability, by a model and as measured.

    Parameters
    ----------
    profile : Profile
        The rig's.
    out : Path
        Where runs are kept.
    """
    from rig.assembly import REGISTRY
    from rig.cli.loops import known_loops, loops_of

    tables, _ = loops_of(profile, known_loops(profile))
    loops = [
        Milestone(f"loop of {name}",
              f"stable: {stable}, crossover {crossover}, phase {phase}, more dead time: {delay}, "
              f"sensitivity {sensitivity}")
        for table in tables
        for name, stable, crossover, phase, delay, sensitivity in table.rows
    ]  # fmt: skip
    if not loops or REGISTRY.measured_loop(profile.mechanism) is None:
        return loops
    measured = list(_measured(profile, out))
    command = f"rig margins {profile.argument}"
    told = f"never: the above is the linear model's: {command} measures it"
    return [*loops, *(measured or [Milestone("loops measured", told)])]


def _measured(profile: Profile, out: Path) -> Iterator[Milestone]:
    """Yield what the last `rig margins` of each law has measured, and whether it still holds."""
    from rig.cli.listing import describe_run
    from rig.run_names import list_runs

    experiment = f"{profile.mechanism}-margins"
    runs = [run for run in map(describe_run, list_runs(out)) if run.experiment == experiment]
    last: dict[str, tuple[RunEntry, str]] = {}
    for run in sorted(runs, key=lambda run: run.started or ""):
        measured = _sensitivity(Path(run.path)) if run.rig == profile.name else None
        if measured is not None and run.law is not None:
            last[run.law] = run, measured
    for law, (run, measured) in last.items():
        tuning, started = profile.tunings.get(law), run.started or ""
        is_older = tuning is not None and tuning.provenance.date[:19] > started[:19]
        again = f"rig margins {profile.argument} --controller {law}"
        told = f"{started[:10]}, on {run.backend}, sensitivity {measured}, {run.path}"
        if is_older:
            told += f"; other gains were found since: {again} measures these"
        yield Milestone(f"loop of {law}, measured", told)


class _Interval(TypedDict):
    measured: float | None
    interval: list[float | None]


class _Told(TypedDict):
    sensitivity: _Interval


class _Loop(_Told, total=False):
    partial: bool
    frequencies: list[float]


class _Kept(TypedDict, total=False):
    now: _Loop
    set: list[str]


def _sensitivity(run: Path) -> str | None:
    """Return the greatest sensitivity that was measured, with its interval; None: there is none."""
    from rig.hal import ConfigurationError
    from rig.run_facts import MARGINS
    from rig.typed_json import read_json

    try:
        kept = read_json(run / MARGINS, _Kept)
    except (ConfigurationError, OSError):
        return None
    if "now" not in kept:  # the run told no loop
        return None
    found, of = kept["now"]["sensitivity"], kept["now"]
    if found["measured"] is None:
        return None
    known = [bound for bound in found["interval"] if bound is not None]
    between = f" (95 %: {known[0]:.3g} to {known[1]:.3g})" if len(known) == 2 else ""
    band = ""
    if of.get("partial") and (f := of.get("frequencies")):
        band = f" from {f[0]:g} to {f[-1]:g} Hz alone"
    otherwise = "".join(f", with {one}" for one in kept.get("set", ()))
    return f"{found['measured']:.3g}{between}{band}{otherwise}"
