"""Trying mutants: one warm process, and a fork of it for each mutant.

mutmut and cosmic-ray do the same for whole packages. Both write each mutant to the disk and start
pytest anew, half a second of imports apiece; here a mutant costs its fork and the few tests that
run its line, some 20 ms, so that all of them can be tried whenever somebody likes.
"""

import gc
import importlib.abc
import importlib.util
import os
import resource
import signal
import sys
import types
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import _lru_cache_wrapper
from pathlib import Path

import hypothesis
import pytest
from changes import Mutant
from coverage import Coverage

ROOT = Path(__file__).parents[2]
KILLED, SURVIVED = 1, 0
_OPTIONS = (
    *("-q", "-n0", "-s", "--no-header", "--no-summary", "-pno:cacheprovider", "-pno:randomly"),
    *("-pno:unraisableexception", "-pno:threadexception"),  # of garbage of the parent's
    *("-Wignore::pytest.PytestAssertRewriteWarning", "--hypothesis-profile=mutants"),
)
_SECONDS, _TIMES = 2.0, 10.0
"""Of processor time that a mutant has at least, and over what its tests take without it."""
_MEMORY = 2 << 30
"""Bytes that a mutant may take beyond what is there: a loop without end may fill a list."""

# Whoever is killed is dead, and needs no smaller example of it.
hypothesis.settings.register_profile(
    "mutants", derandomize=True, database=None, deadline=None, print_blob=False,
    phases=(hypothesis.Phase.explicit, hypothesis.Phase.generate),
)  # fmt: skip


class Verdict:
    """A plugin of pytest that ends the process with the first test that fails."""

    def pytest_runtest_makereport(self, call: pytest.CallInfo) -> None:
        """End at once: nobody reads why."""
        if call.excinfo is not None and not call.excinfo.errisinstance(pytest.skip.Exception):
            os._exit(KILLED)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """End as well where the tests cannot even be imported."""
        if report.failed:
            os._exit(KILLED)


def forked(work: Callable[[], int], seconds: float) -> int:
    """Return how a piece of work ended in a process of its own, KILLED if it took too long."""
    child = os.fork()
    if child == 0:
        code = KILLED
        try:
            signal.setitimer(signal.ITIMER_PROF, seconds)
            # For those that wait for ever; what only computes may be slow on a busy machine.
            signal.alarm(60 + 2 * int(seconds))
            size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (size + _MEMORY, size + _MEMORY))
            code = work()
        finally:
            os._exit(code)
    return KILLED if os.waitpid(child, 0)[1] else SURVIVED


def spread(works: Sequence[Callable[[], int]], workers: int) -> list[int]:
    """Return what each piece of work comes to, shared by some processes."""
    pipes = []
    for worker in range(workers):
        reader, writer = os.pipe()
        if os.fork() == 0:
            found = bytearray(len(works))
            for k in range(worker, len(works), workers):
                found[k] = works[k]()
            with os.fdopen(writer, "wb") as stream:
                stream.write(found)
            os._exit(0)
        os.close(writer)
        pipes.append(reader)
    parts = []
    for reader in pipes:
        with os.fdopen(reader, "rb") as stream:
            parts.append(stream.read())
        os.wait()
    return [max(part[k] for part in parts) for k in range(len(works))]


class Warm:
    """A plugin of pytest: all is imported and has run once, then each mutant is forked off.

    A mutant takes the place of the code of the functions that are there already.

    Parameters
    ----------
    mutants : sequence of Mutant
        Tried; a file's own tests have to kill them.
    tests : mapping
        Of each file, those of its own.
    workers : int
        How many processes share them.
    """

    def __init__(
        self, mutants: Sequence[Mutant], tests: dict[str, tuple[str, ...]], workers: int
    ) -> None:
        self._mutants = mutants
        self._tests = tests
        self._workers = workers
        self._coverage = Coverage(data_file=None, include=[str(ROOT / path) for path in tests])
        self._seconds: dict[str, float] = defaultdict(float)
        self.found: list[int] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note how long a test takes; what fails without a mutant would fail with each."""
        if report.failed:
            sys.exit(f"{report.nodeid} fails without any mutant:\n{report.longreprtext}")
        self._seconds[report.nodeid] += report.duration

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run every test once, then those of each mutant in a fork."""
        self._coverage.start()
        for item, follower in _in_turn(session.items):
            self._coverage.switch_context(item.nodeid)
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=follower)
        self._coverage.stop()
        session.config.pluginmanager.unregister(self)
        session.config.pluginmanager.register(Verdict())
        gc.unfreeze()
        self._functions = _functions_of(self._tests)
        self._caches = [one for one in gc.get_objects() if type(one) is _lru_cache_wrapper]
        gc.freeze()
        if forked(lambda: _run(session.items), 600.0) == KILLED:
            sys.exit("the tests fail in a fork without any mutant")
        works = [self._work(session, mutant) for mutant in self._mutants]
        self.found = spread(works, self._workers)
        return True

    def _work(self, session: pytest.Session, mutant: Mutant) -> Callable[[], int]:
        def run() -> int:
            return forked(lambda: self._try(mutant, items), _SECONDS + _TIMES * expected)

        data = self._coverage.get_data()
        contexts = data.contexts_by_lineno(str(ROOT / mutant.path))
        own = tuple(f"tests/unit/{name}::" for name in self._tests[mutant.path])
        lines = range(mutant.line, mutant.last + 1)
        covering = {test for line in lines for test in contexts.get(line, ())}
        items = [i for i in session.items if i.nodeid in covering and i.nodeid.startswith(own)]
        items.sort(key=lambda item: self._seconds[item.nodeid])
        expected = sum(self._seconds[item.nodeid] for item in items)
        return run

    def _try(self, mutant: Mutant, items: Sequence[pytest.Item]) -> int:
        file = str(ROOT / mutant.path)
        _replace(compile(mutant.tree(), file, "exec"), self._functions[file])
        for cache in self._caches:
            cache.cache_clear()
        return _run(items)


def _run(items: Sequence[pytest.Item]) -> int:
    for item, follower in _in_turn(items):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=follower)
    return SURVIVED


def _in_turn(items: Sequence[pytest.Item]) -> Iterable[tuple[pytest.Item, pytest.Item | None]]:
    return zip(items, [*items[1:], None], strict=True)


Functions = dict[tuple[str, int], list[types.FunctionType]]


def _functions_of(paths: Iterable[str]) -> dict[str, Functions]:
    """Return the functions of each file that are there, by name and line."""
    found: dict[str, Functions] = {str(ROOT / path): defaultdict(list) for path in paths}
    for thing in gc.get_objects():
        if type(thing) is types.FunctionType and thing.__code__.co_filename in found:
            code = thing.__code__
            found[code.co_filename][code.co_qualname, code.co_firstlineno].append(thing)
    return found


def _replace(code: types.CodeType, functions: Functions) -> None:
    for part in code.co_consts:
        if isinstance(part, types.CodeType):
            for function in functions.get((part.co_qualname, part.co_firstlineno), ()):
                if len(function.__code__.co_freevars) == len(part.co_freevars):
                    function.__code__ = part
            _replace(part, functions)


def try_warm(
    mutants: Sequence[Mutant], tests: dict[str, tuple[str, ...]], workers: int
) -> list[int]:
    """Return what each mutant comes to whose change is within a function.

    All of it is in a process of its own, so that this one stays without any code of ours.
    """
    reader, writer = os.pipe()
    if os.fork() == 0:
        warm = Warm(mutants, tests, workers)
        files = sorted({f"tests/unit/{name}" for names in tests.values() for name in names})
        os.chdir(ROOT)
        pytest.main([*_OPTIONS, *files], [warm])
        with os.fdopen(writer, "wb") as stream:
            stream.write(bytes(warm.found))
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as stream:
        found = list(stream.read())
    os.wait()
    if len(found) != len(mutants):
        sys.exit("the tests do not pass without any mutant")
    return found


class _Mutated(importlib.abc.MetaPathFinder, importlib.abc.SourceLoader):
    """Imports a mutant in place of its file."""

    def __init__(self, mutant: Mutant) -> None:
        self._mutant = mutant
        self._name = mutant.path.removesuffix(".py").replace("/", ".")

    def find_spec(self, name, path=None, target=None):
        if name != self._name:
            return None
        return importlib.util.spec_from_file_location(name, self.get_filename(name), loader=self)

    def get_filename(self, fullname: str) -> str:
        return str(ROOT / self._mutant.path)

    def get_data(self, path: str) -> bytes:
        return self._mutant.source.encode()

    def path_stats(self, path):
        raise OSError("its compiled code is not to be kept")

    def source_to_code(self, data, path, *, _optimize=-1):
        return compile(self._mutant.tree(), path, "exec")


def try_fresh(mutant: Mutant, tests: Sequence[str]) -> int:
    """Return what a mutant comes to that is imported in place of its file, before its tests."""

    def work() -> int:
        sys.meta_path.insert(0, _Mutated(mutant))
        sys.stdout = sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115 - the process ends
        files = [f"tests/unit/{name}" for name in tests]
        return int(pytest.main([*_OPTIONS, *files], [Verdict()]))

    return forked(work, 60.0)
