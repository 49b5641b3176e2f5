"""How costs grow: a bus's devices, a log's channels, a run's length, a sweep's points and workers.

Prints a table, and draws it.

    python tests/benchmarks/scale.py [--figure .readme/scale.png]
    python tests/benchmarks/scale.py --only report npz --minutes 1 600 --discard

Ten hours take 25 GB of disk for a while, and as much again for what is exported without --discard.

Processor time each, so that neighbours of this machine matter little; the least of a few rounds.
Memory is what no file stands behind (`RssAnon` of the process that has most): the system takes the
pages of files back when it needs them.
Slopes are those of straight lines through the logarithms: 1 is linear.
"""

import argparse
import contextlib
import itertools
import json
import os
import re
import shutil
import sys
import time
from contextlib import closing
from pathlib import Path

import endings
from endings import Unmeasured, called, folder_for_a_while, last_line

if __name__ == "__main__":
    endings.take_over()

import numpy as np

try:
    import test_sweep_cost
except ModuleNotFoundError:
    sys.exit("this needs pytest and what comes with it: pip install -e '.[test]'")
from asked_minutes import whole_minutes
from bench_rig import armed_rig, run
from test_cycle_cost import CycleCosts
from test_log_cost import record

import rig
from rig.assembly import REGISTRY, Backend
from rig.config import find_configs, load_profile
from rig.experiment.measure import PHASE_RUN
from rig.hal.columns import Column
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.run_facts import EVALUATION
from rig.runtime.log import read_log
from rig.runtime.recorder import LogRecorder
from rig.sweeping.engine import WorkerSetup
from rig.sweeping.pool import Pool

ENCODERS = (0, 1, 5, 13, 21, 29)
"""Beside the three devices of the pair, all on one bus of 1 Mbit/s."""
SLOW = (
    "loop.rate=100 Hz",
    "controllers.cascade.position_rate=20",
    "controllers.cascade.velocity_rate=30",
    "controllers.cascade.integral=300",
    "controllers.cascade.observer_bandwidth=200",
    "controllers.cascade.lead_bandwidth=60",
    "controllers.cascade.disturbance_gain=0",
    "cylinder.limits.following=15 mm",
)
"""That loop: a bus that carries 32 devices carries no more a second, and so slow a loop bears only
soft gains. At 250 Hz the bus is full at 13 devices, and a profile with more is refused."""
CHANNELS = (10, 30, 100, 300, 1000)
MINUTES = (1, 4, 15, 60)
"""Of a run at 1 kHz, whose log has the columns of the pair's."""
POINTS = (10, 100, 1000, 10_000)
"""Of a sweep, which cost nothing themselves."""
WORKERS = (1, 2, 4, 8, 16)
WAITING = 32
"""Points of a second each, for which they wait: what is shared out is not this machine's work."""
ROUNDS = 3
FIGURES = (".png", ".svg", ".pdf")
ONE = """
import resource, sys, time
import rig.export, rig.report.regenerate
began = time.process_time()
{work}
spent = time.process_time() - began
print(spent + sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]))
"""
WORKS = {
    "csv": "rig.export.export_run(sys.argv[1], 'csv', sys.argv[2])",
    "npz": "rig.export.export_run(sys.argv[1], 'npz', sys.argv[2])",
    "report": "rig.report.regenerate.write_report(sys.argv[1])",
}


def say(line):
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def slope(x, y):
    """Return the exponent of a power law through points."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def memory_of(pid):
    """Return the memory of a process and of those that it began which no file stands behind, MB."""
    found = []
    with contextlib.suppress(OSError):  # it has ended
        told = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        found += [int(kb) / 1024 for kb in re.findall(r"RssAnon:\s+(\d+)", told)]
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8")
        found += itertools.chain.from_iterable(map(memory_of, children.split()))
    return found


def time_and_memory(*words):
    """Return the time that a program in Python prints first, s, and its greatest memory, MB."""
    seen = []
    done = called(sys.executable, *words, look=lambda pid: seen.extend(memory_of(pid)))
    if done.returncode:
        raise Unmeasured(last_line(done))
    return float(done.stdout.split()[0]), max(seen)


def cycle_costs(folder):
    """Return the median cost of a cycle, s, by the nodes on the bus."""
    wired = AntagonisticPair.wiring
    extras = dict.fromkeys((f"extra-{k}" for k in range(max(ENCODERS))), "agonist")
    AntagonisticPair.wiring = staticmethod(lambda settings: {**wired(settings), **extras})
    costs = []
    for count in ENCODERS:
        more = [
            f"devices.extra-{k}={{driver: cia406, bus: can0, node: {0x30 + k}, stroke: 60 mm, "
            "max_speed: 1 m/s}"
            for k in range(count)
        ]
        words = [*SLOW, *more]
        profile = load_profile("cylinder", REGISTRY, words, find_configs())
        best = np.inf
        for number in range(ROUNDS):
            with armed_rig(Backend.VIRTUAL, profile) as its:
                clock = CycleCosts(its.clock)
                run(its, folder / f"cycle-{count}-{number}.mcap", 14.0, clock=clock)
            best = min(best, float(np.median(clock.costs)))
        costs.append(best)
    return [3 + count for count in ENCODERS], costs


def log_costs(folder):
    """Return the cost of a row, s, by its channels."""
    costs = []
    for count in CHANNELS:
        columns = [Column(f"group{n // 5}.value{n}", "m", "a number") for n in range(count)]
        rows = [tuple(0.1 * k + n for n in range(count)) for k in range(500)]
        files = [folder / f"log-{count}-{k}.mcap" for k in range(ROUNDS + 1)]
        rounds = [record(file, columns, rows) for file in files]
        costs.append(min(rounds[1:]))
    return list(CHANNELS), costs


def lengthen(source, folder, minutes):
    """Make a run folder whose log goes on for so long: rows of a recorded run, over and over.

    The reference's time goes on with them, and so do the segments, so that all metrics are those of
    the whole run.
    """
    folder.mkdir()
    for path in source.iterdir():
        if path.is_file() and path.name not in ("log.mcap", "report.html", "metrics.json"):
            (folder / path.name).write_bytes(path.read_bytes())
    log = read_log(source / "log.mcap")
    rows = log.values[log.column("phase") == PHASE_RUN]
    period = float(np.median(np.diff(log.t)))
    place = [column.name for column in log.columns].index("reference.time")
    count = round(60 * minutes / period)
    with LogRecorder(folder / "log.mcap", log.columns, wall_clock_ns=0) as recorder:
        for k in range(count):
            row = rows[k % len(rows)].tolist()
            row[place] = k * period
            recorder.write(k, k * period, row)
    told = json.loads((folder / EVALUATION).read_text(encoding="utf-8"))
    longer = count / len(rows)
    for segment in told["segments"]:
        segment["start"], segment["end"] = segment["start"] * longer, segment["end"] * longer
    (folder / EVALUATION).write_text(json.dumps(told), encoding="utf-8")
    return folder


def length_costs(folder, works, lengths, out=None):
    """Return time (s) and memory (MB) of what is done with a run, by its minutes.

    What is exported goes into the run's folder, and is taken away, or to `out`.
    """
    source = rig.run("cylinder-sine", on="sim", report=False, out=folder / "runs").path
    found = {name: [] for name in works}
    for minutes in lengths:
        long = lengthen(Path(source), folder / f"of-{minutes}", minutes)
        for name, work in works.items():
            words = "-c", ONE.format(work=work), str(long), out or f"{long}/out"
            found[name].append(time_and_memory(*words))
            say(f"{name}, {minutes} min: {found[name][-1][0]:.1f} s, {found[name][-1][1]:.0f} MB")
            (long / "out").unlink(missing_ok=True)
        shutil.rmtree(long)
    return found


def point_costs(folder):
    """Return processor time of a sweep (s) and memory (MB), by its points."""
    found = []
    for count in POINTS:
        words = test_sweep_cost.__file__, str(folder / f"points-{count}"), str(count)
        found.append(time_and_memory(*words))
    return found


def worker_costs(folder):
    """Return how many points of a second a sweep goes through in one, by its workers."""
    found = []
    for count in WORKERS:
        with closing(Pool(count, WorkerSetup("test_sweep_cost:perform_waiting"))) as engine:
            test_sweep_cost.sweep_through(engine, folder / f"warm-{count}", 2 * count)
            spent = test_sweep_cost.sweep_through(engine, folder / f"workers-{count}", WAITING)
        found.append(WAITING / spent)
    return found


def tell_sweeps(points, workers):
    """Say what `point_costs` and `worker_costs` found."""
    row = "  ".join(
        f"{n}: {1e3 * s / n:.2f} ms, {mb:.0f} MB" for n, (s, mb) in zip(POINTS, points, strict=True)
    )
    say(f"a point of a sweep, by points: {row}; slope {slope(POINTS, [s for s, _ in points]):.2f}")
    row = "  ".join(f"{n}: {rate:.2f}" for n, rate in zip(WORKERS, workers, strict=True))
    say(f"points of a second, a second, by workers: {row}; slope {slope(WORKERS, workers):.2f}")


def draw(path, cycles, logs, minutes, lengths, points, workers):
    """Draw the curves."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 3, figsize=(12, 6.6), layout="constrained")
    axes = axes.ravel()
    for axis, (x, y), what in (
        (axes[0], cycles, "devices on a bus"),
        (axes[1], logs, "channels of a log"),
    ):
        axis.plot(x, 1e6 * np.array(y), "o-")
        axis.set(xlabel=what, ylabel="µs a cycle", ylim=(0, 1.1e6 * max(y)))
    for name, rows in lengths.items():
        seconds, memory = np.array(rows).T
        axes[2].plot(minutes, seconds, "o-", label=name)
        axes[3].plot(minutes, memory, "o-", label=name)
    axes[2].set(xlabel="length of a run at 1 kHz, min", ylabel="s", xscale="log", yscale="log")
    axes[3].set(xlabel="length of a run at 1 kHz, min", ylabel="MB", xscale="log", ylim=(0, None))
    axes[2].legend()
    axes[3].legend()
    each = [1e3 * spent / count for count, (spent, _) in zip(POINTS, points, strict=True)]
    axes[4].plot(POINTS, each, "o-")
    axes[4].set(
        xlabel="points of a sweep", ylabel="ms a point", xscale="log", ylim=(0, 1.1 * max(each))
    )
    axes[5].plot(WORKERS, workers, "o-")
    axes[5].set(
        xlabel="workers of a sweep", ylabel="points of 1 s done in a second", ylim=(0, None)
    )
    axes[5].set_xticks(WORKERS)
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.savefig(path, dpi=110)


def tell_lengths(minutes, lengths):
    """Say what `length_costs` found."""
    for name, rows in lengths.items():
        row = "  ".join(
            f"{m}: {s:.1f} s, {mb:.0f} MB" for m, (s, mb) in zip(minutes, rows, strict=True)
        )
        grows = slope(minutes, [s for s, _ in rows]) if len(rows) > 1 else np.nan
        say(f"{name}, by minutes: {row}; slope {grows:.2f}")


def figure_file(text):
    """Return where to draw to, if that can be done: hours of measuring come first."""
    path = Path(text)
    if not os.access(path.parent, os.W_OK) or path.is_dir():
        raise argparse.ArgumentTypeError(f"{text} cannot be written")
    if path.suffix not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text} ends in none of {', '.join(FIGURES)}")
    return path


def measure_all(folder, asked):
    """Measure what is asked for, say it, and draw it."""
    if asked.only is not None:
        works = {name: WORKS[name] for name in asked.only}
        out = os.devnull if asked.discard else None
        tell_lengths(asked.minutes, length_costs(folder, works, asked.minutes, out))
        return
    cycles, logs = cycle_costs(folder), log_costs(folder)
    for what, (x, y) in (("cycle, us, by devices", cycles), ("log, us, by channels", logs)):
        row = "  ".join(f"{n}: {1e6 * cost:.1f}" for n, cost in zip(x, y, strict=True))
        say(f"{what}: {row}; slope {slope(x, y):.2f}")
    points, workers = point_costs(folder), worker_costs(folder)
    tell_sweeps(points, workers)
    lengths = length_costs(folder, WORKS, asked.minutes)
    tell_lengths(asked.minutes, lengths)
    if asked.figure is not None:
        draw(asked.figure, cycles, logs, asked.minutes, lengths, points, workers)


def main():
    """Measure, and say it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--figure", type=figure_file, help="where the curves are drawn")
    parser.add_argument(
        "--only", choices=WORKS, nargs="+", help="these alone, over the length of a run"
    )
    parser.add_argument("--discard", action="store_true", help="export to nowhere")
    parser.add_argument(
        "--minutes", type=whole_minutes, nargs="+", default=MINUTES,
        help="lengths of the run; 600 are 12 GB",
    )  # fmt: skip
    parser.add_argument("--folder", help="where the logs are written meanwhile")
    asked = parser.parse_args()
    began = time.monotonic()
    try:
        with folder_for_a_while("scale-", asked.folder) as folder:
            measure_all(folder, asked)
    except rig.RunInterrupted:
        raise
    except rig.RigError as error:
        raise Unmeasured(str(error)) from error
    say(f"it took {time.monotonic() - began:.0f} s")
    return 0


if __name__ == "__main__":
    endings.end(main())
