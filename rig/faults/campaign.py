"""Many cases, each in a process of its own, as many at once as there are workers."""

import multiprocessing
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from rig.faults.case import Case, draw_case, seed_of
from rig.faults.catalogue import KINDS, kinds_for
from rig.faults.performance import perform
from rig.faults.subject import Subject
from rig.faults.verdict import Ending, Verdict, give_verdict
from rig.hal import ConfigurationError

DOUBLES = 0.15
"""Share of the cases drawn at random in which a second fault follows."""
DEADLINE = 300.0
"""How long a case may take by the wall's clock, s: it hangs."""

Job = tuple[Case, Subject]


def draw_once(subject: Subject, kinds: tuple[str, ...], seed: int, times: int) -> list[Case]:
    """Draw cases of chosen kinds; the first has the seed itself.

    Raises
    ------
    ConfigurationError
        There is no such kind, or the rig has nothing that could suffer it.
    """
    possible = kinds_for(subject)
    for name in kinds:
        if name not in KINDS:
            raise ConfigurationError(f"no fault is called {name!r}; `rig faults list` shows all")
        if name not in possible:
            raise ConfigurationError(f"{subject.rig} has nothing that could suffer {name}")
    seeds = [seed, *(seed_of(seed, number) for number in range(1, times))]
    return [draw_case(subject, kinds, one, energised=False) for one in seeds]


def draw_each(subject: Subject, seed: int, times: int) -> list[Case]:
    """Draw cases of every kind that a rig can suffer, `times` each."""
    return [
        draw_case(subject, (name,), seed_of(seed, subject.rig, name, number), energised=False)
        for name in kinds_for(subject)
        for number in range(times)
    ]


def draw_random(subject: Subject, seed: int, count: int) -> list[Case]:
    """Draw kinds at random, now and then two in one case."""
    chance = random.Random(f"{seed} {subject.rig}")
    names = [name for name in kinds_for(subject) if name != "nothing"]
    cases = []
    for number in range(count):
        kinds = tuple(chance.sample(names, 2 if chance.random() < DOUBLES else 1))
        one = seed_of(seed, subject.rig, number)
        cases.append(draw_case(subject, kinds, one, energised=False))
    return cases


def run_cases(
    jobs: Sequence[Job],
    out: Path,
    configs: Path | None,
    workers: int,
    progress: Callable[[Verdict], None],
) -> list[Verdict]:
    """Run cases, and return their verdicts in the cases' order.

    Parameters
    ----------
    jobs : sequence of (Case, Subject)
        What to do.
    out : Path
        Where the run folders go; those of cases in which nothing is wrong are removed.
    configs : Path, optional
        The folder of the configurations.
    workers : int
        How many at once.
    progress : callable
        Told each verdict as it comes.
    """
    context = multiprocessing.get_context("fork")  # what is imported and compiled is there
    verdicts: dict[int, Verdict] = {}
    waiting = list(enumerate(jobs))[::-1]
    running: dict[Connection, tuple[int, BaseProcess]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                number, job = waiting.pop()
                receiver, sender = context.Pipe(duplex=False)
                arguments = (job, out / f"{number:05d}", configs, sender)
                process: BaseProcess = context.Process(target=_work, args=arguments)
                process.start()
                sender.close()
                running[receiver] = (number, process)
            for receiver in _ready(running):
                number, process = running.pop(receiver)
                verdict = _received(receiver, jobs[number])
                _bury(process)
                verdicts[number] = verdict
                progress(verdict)
    finally:
        for _, process in running.values():
            process.kill()
    return [verdicts[number] for number in range(len(jobs))]


def _ready(running: dict[Connection, tuple[int, BaseProcess]]) -> Iterator[Connection]:
    ready = wait(list(running), timeout=DEADLINE)
    for receiver in ready or list(running):  # none for so long: they hang
        assert isinstance(receiver, Connection)
        yield receiver


def _received(receiver: Connection, job: Job) -> Verdict:
    case, subject = job
    if receiver.poll():
        with suppress(EOFError):
            verdict = receiver.recv()
            assert isinstance(verdict, Verdict)
            return verdict
    # It ended without a word, or hangs: the campaign's own failure is never taken for a pass.
    return give_verdict(case, Ending(None, "the case gave no verdict", 0.0, None), subject).broken()


def _bury(process: BaseProcess) -> None:
    process.join(5.0)
    if process.is_alive():
        process.kill()
        process.join()


def _work(job: Job, out: Path, configs: Path | None, sender: Connection) -> None:
    """Run one case in this process, silently; keep its folder if something is wrong."""
    import os
    import shutil

    case, subject = job
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)

    def tell(verdict: Verdict) -> None:
        if not verdict.failed:
            shutil.rmtree(out, ignore_errors=True)
        sender.send(verdict)
        sender.close()

    perform(case, subject, out, configs, tell)
