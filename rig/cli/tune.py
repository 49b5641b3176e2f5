"""`rig tune`: gains that a rig and its uncertainty bear."""

from __future__ import annotations

import getpass
import hashlib
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rig.cli.given_options import given_options
from rig.cli.names import (
    complete_config,
    complete_rig,
    configs_option,
    json_option,
    law_option,
    out_option,
    set_option,
    workers_option,
)
from rig.cli.tables import Table, print_json, print_tables

if TYPE_CHECKING:
    from rig.tuning.search import FoundGains
    from rig.tuning.verdict import EnsembleVerdict
    from rig.tuning.workbench import Request, Workbench


_KEPT = ("controller", "experiment", "seed", "workers", "out", "overrides", "configs")
"""Options with which more generations go on from what was tried."""


@click.command()
@click.argument("rig", shell_complete=complete_rig)
@law_option
@click.option(
    "--for", "experiment", metavar="EXPERIMENT", shell_complete=complete_config,
    help="Tune for its motion; default: slow and fast ones of the rig, and holds.",
)  # fmt: skip
@click.option("--generations", type=click.IntRange(3), default=60, show_default=True,
              help="Of twelve candidates each.")  # fmt: skip
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True,
              help="Of the plants and of the search.")  # fmt: skip
@workers_option
@click.option("--dry-run", is_flag=True, help="Search and judge, but put nothing in force.")
@click.option(
    "--replace",
    is_flag=True,
    help="Put in force what is found, though it be worse in cost or in a bound.",
)
@click.option("--operator", default=None, help="Who tunes; default: the user's name.")
@out_option
@set_option
@configs_option
@json_option
def tune(rig: str, controller: str, experiment: str | None, **options: Any) -> int:
    """Find gains of RIG's law, and write configs/calibration/RIG/controllers.LAW.yaml.

    The law runs on simulated plants that are as the profile and its calibration say, and on
    others within what they leave open. Gains are put in force that keep their distance from
    instability on all of them; the older file is kept, as by `rig calibrate`, whose --history,
    --diff and --restore take controllers.LAW for a device: `rig calibrate RIG --restore
    controllers.LAW/profile` goes back to the profile's own gains. Interrupted, the same command
    goes on from what it has kept among the runs.
    """
    from rig.calibration.store import check_writable
    from rig.cli.judge_progress import JudgeProgress
    from rig.config.names import find_configs, say_where
    from rig.installation import need
    from rig.sweeping.errors import SweepStopped
    from rig.tuning.attempt import keep_attempt
    from rig.tuning.search import GainSearch
    from rig.tuning.verdict import in_short, judge, objections, other_levers, plants_of, trades
    from rig.tuning.workbench import Request, Workbench

    need("cma", "matplotlib")  # which draws what was found
    configs = options["configs"]
    request = Request(
        rig, controller, experiment, tuple(options["overrides"]),
        None if configs is None else str(configs.resolve()), options["seed"],
    )  # fmt: skip
    bench, places = Workbench(request), find_configs(configs)
    folder = _folder(options["out"], bench, request)
    _announce(bench, options["generations"], folder)
    if not options["dry_run"]:
        check_writable(places[0], bench.profile.name)
        click.echo(f"gains are put in force in {say_where(places[0])}", err=True)
    try:
        search = GainSearch(
            bench, request, folder, options["workers"],
            options["generations"],
        )  # fmt: skip
        found = search.run()
    except SweepStopped as stop:
        click.echo(f"tune: {stop}", err=True)
        return 3
    except KeyboardInterrupt:
        click.echo(f"interrupted; the same command goes on from {folder}", err=True)
        return 130
    with JudgeProgress(2 * plants_of(bench, found.gains)) as shown:
        before, now = (judge(bench, gains, shown.tell) for gains in (search.before, found.gains))
    against = objections(now, before, bench.unit)
    refused = bool(against) and not options["replace"]
    is_put = not refused and not options["dry_run"]
    if not options["as_json"]:
        _show(bench, before, now)
    _draw(folder, found, now, before)
    for objection in against:
        click.echo(f"against these gains: {objection}", err=True)
    traded = trades(now, before, bench.unit)
    for sentence in (*traded, *filter(None, [other_levers(now)])):
        click.echo(sentence, err=True)
    attempt = keep_attempt(
        folder, controller, options["generations"], against, given_options(_KEPT), is_put=is_put
    )
    file = _apply(bench, request, before, now, places, options) if is_put else None
    if options["as_json"]:
        print_json({
            "folder": folder, "unit": bench.unit, "before": _as_data(before), "now": _as_data(now),
            "objections": against, "trades": traded, "file": file,
        })  # fmt: skip
    short = f"in short: {in_short(now, before, bench.unit)}"
    if options["dry_run"]:
        click.echo(f"{short}: a dry run, nothing was changed", err=True)
        return 0
    if refused:
        click.echo(
            f"nothing was changed; more generations: {attempt.for_more(bench.profile.argument)}; "
            "--replace puts these in force all the same",
            err=True,
        )
        click.echo(f"{short}: not put in force", err=True)
        return 1
    click.echo(f"{short}: put in force", err=True)
    return 0


def _as_data(verdict: EnsembleVerdict) -> dict[str, object]:
    """Return what gains came to as plain data, SI: what is not finite was lost."""
    names = verdict.nominal.errors
    return {
        "gains": verdict.gains,
        "told": {name: verdict.nominal.errors[name] for name in names},
        "worst": {name: verdict.worst(name)[0] for name in names},
        "worst_on": {name: verdict.worst(name)[1].name for name in names},
        "hunting": verdict.hunting,
        "reversals": verdict.reversals,
        "lost": [member.name for member in verdict.lost],
        "robust": verdict.robust,
        "drawn": {
            "plants": len(verdict.margins), "told": verdict.told, "keep": verdict.keeping,
            "measured": verdict.measured,
        },
        "linear_sensitivity": _linear(verdict),
        "cost": verdict.cost,
    }  # fmt: skip


def _linear(verdict: EnsembleVerdict) -> float | None:
    """Return the linear model's sensitivity on the plant as told; None: the loop is not stable."""
    loop = verdict.linear
    return loop.sensitivity if loop is not None and loop.stable else None


def _folder(out: Path, bench: Workbench, request: Request) -> Path:
    from rig.config.dump import dump_resolved
    from rig.sweeping.code import code_version
    from rig.tuning.attempt import folder_prefix

    text = f"{request.text()} {dump_resolved(bench.profile)} {code_version().digest}"
    name = hashlib.sha256(text.encode()).hexdigest()[:8]
    return out / f"{folder_prefix(bench.profile.name, request.controller)}{name}"


def _announce(bench: Workbench, generations: int, folder: Path) -> None:
    from rig.tuning.ensemble import NOISIER
    from rig.tuning.jury import SHAKEN_AT_ONCE
    from rig.tuning.search import FIRST_LOOK, GENERATION, LAST_LOOK, trials_of

    bounds = ", ".join(f"{name} {text}" for name, text in bench.ensemble.ranges().items())
    click.echo(
        f"{len(bench.tunables)} gains; {FIRST_LOOK} generations of {GENERATION} that look beside "
        f"those in force and anywhere, a walk that moves one gain after the other, then "
        f"{generations} that go on from the best: "
        f"at most {trials_of(generations, len(bench.tunables))} trials, each on several plants for "
        f"{bench.duration:.0f} s, and the best {LAST_LOOK} on all "
        f"{len(bench.ensemble.corners())} plants: {bounds}, "
        f"and one whose encoders have {NOISIER:g} times the noise",
        err=True,
    )
    click.echo(
        "the progress line counts these trials, the last look at the best, and beside them jobs "
        f"that shake {SHAKEN_AT_ONCE} drawn plants each; it says how long the rest takes",
        err=True,
    )
    click.echo(f"what is tried is kept in {folder}", err=True)
    others = sorted(folder.parent.glob(folder.name.rpartition("-")[0] + "-" + 8 * "[0-9a-f]"))
    if others and folder not in others:
        click.echo(
            f"it begins anew: {', '.join(other.name for other in others)} had another profile, "
            "other options, or another state of the code and of the packages beside it",
            err=True,
        )


def _show(bench: Workbench, before: EnsembleVerdict, now: EnsembleVerdict) -> None:
    from rig.config import format_quantity

    def text(value: float) -> str:
        return format_quantity(value, bench.unit) if value < float("inf") else "lost"

    rows = []
    for name in now.nominal.errors:
        told = [text(verdict.nominal.errors.get(name, float("inf"))) for verdict in (before, now)]
        worst = [verdict.worst(name) for verdict in (before, now)]
        rows.append((f"error, {name}", *told, *(text(value) for value, _ in worst),
                     worst[1][1].name or "as told"))  # fmt: skip
    head = ("rms", "told: before", "now", "worst: before", "now", "worst where")
    measured = ", measured" if now.measured else ""
    quiet = [
        ("hunting", text(before.hunting), text(now.hunting)),
        ("reversals of a setpoint", *(f"{v.reversals:.1f} /s" for v in (before, now))),
        ("lost plants", str(len(before.lost)), str(len(now.lost))),
        ("drawn plants that were told", *(f"{v.told} of {len(v.margins)}" for v in (before, now))),
        (
            "drawn plants with enough margin",
            *(f"{v.keeping} of {len(v.margins)}{measured}" for v in (before, now)),
        ),
        ("sensitivity as told, linear", *(_or_unstable(_linear(v)) for v in (before, now))),
        ("cost", f"{before.cost:.3f}", f"{now.cost:.3f}"),
    ]  # fmt: skip
    gains = [(name, f"{before.gains[name]:g}", f"{gain:g}") for name, gain in now.gains.items()]
    print_tables([
        Table("errors on the plant as told, and on the worst", head, rows),
        Table("the most on any plant", ("what", "before", "now"), quiet),
        Table("gains", ("gain", "before", "now"), gains),
    ])  # fmt: skip


def _or_unstable(sensitivity: float | None) -> str:
    return "not stable" if sensitivity is None else f"{sensitivity:.3g}"


def _draw(folder: Path, found: FoundGains, now: EnsembleVerdict, before: EnsembleVerdict) -> None:
    from rig.tuning.figure import draw_tuning

    for path in draw_tuning(folder / "tuning", found.costs, now, before):
        click.echo(str(path), err=True)


def _apply(
    bench: Workbench, request: Request, before: EnsembleVerdict, now: EnsembleVerdict,
    search: Sequence[Path], options: dict[str, Any],
) -> Path:  # fmt: skip
    """Put gains in force, and return their file."""
    from rig.assembly import REGISTRY
    from rig.cli.status import tell_both, way
    from rig.config import load_profile
    from rig.config.laid_over import TUNED
    from rig.tuning.overlay import put_in_force

    begun = " ".join(f"{name}={gain:g}" for name, gain in before.gains.items())
    facts = {
        "begun at": f"{begun}, at a cost of {before.cost:.3f}",
        "command": shlex.join(["rig", *sys.argv[1:]]),
        "tuned for": request.experiment or "sines and holds",
        "generations": str(options["generations"]),
    }
    path = put_in_force(
        bench, request, now, search=search, operator=options["operator"] or getpass.getuser(),
        facts=facts,
    )  # fmt: skip
    click.echo(str(path), err=True)
    if request.experiment is None:
        told = (
            "tuned for the rig's usual sines and holds: steps and quicker motions may be lost with "
        )
        click.echo(f"{told}these gains; --for EXPERIMENT tunes for another motion", err=True)
    else:
        click.echo(f"tuned for {request.experiment}: other motions may need other gains", err=True)
    if REGISTRY.measured_loop(bench.profile.mechanism) is not None:
        measure = f"rig margins {bench.profile.argument} --controller {request.controller}"
        click.echo(
            f"on the rig itself, {measure} --on hardware measures the loop with these gains, and "
            "takes them back if it is nearer to instability than before",
            err=True,
        )
    click.echo(
        f"back to the profile's own gains: rig calibrate {bench.profile.argument} --restore "
        f"{TUNED}{request.controller}/profile",
        err=True,
    )
    profile = load_profile(request.rig, REGISTRY, (), search)
    tell_both(profile, search, way(profile, search, options["out"]))
    return path
