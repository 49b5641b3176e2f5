"""Change the safety core in every small way there is: its own tests have to notice each.

``python tests/mutation [WORD...]`` tries all mutants of the files whose path has one of the words,
or of all, and ends with 1 if one survives that is not listed as equivalent.
"""

import argparse
import importlib
import os
import random
import sys
import tempfile
import time
from collections import Counter
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
_HEAVY = ("numpy", "numba", "scipy.optimize", "pydantic", "can", "canopen", "hypothesis.stateful")
"""Imported before anything of ours, once for all mutants."""


def main() -> int:
    """Try what the command line asks for, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("words", nargs="*", metavar="WORD", help="part of a path")
    parser.add_argument("--sample", type=int, help="how many mutants, drawn; all by default")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    asked = parser.parse_args()
    # A mutant that looks for the user's folder elsewhere than the tests say must not find theirs.
    home = tempfile.TemporaryDirectory()
    os.environ["HOME"] = home.name
    from changes import mutants_of
    from equivalents import EQUIVALENTS
    from safety_core import SAFETY_CORE

    began = time.monotonic()
    paths = [
        path for path in SAFETY_CORE if not asked.words or any(word in path for word in asked.words)
    ]
    mutants = [mutant for path in paths for mutant in mutants_of(ROOT, path)]
    keys = Counter(map(_key, mutants))
    listed = {equivalent[:3] for equivalent in EQUIVALENTS if equivalent.path in paths}
    wrong = [f"no such mutant: {' | '.join(key)}" for key in sorted(listed - set(keys))]
    if asked.sample is not None:
        mutants = random.Random(asked.seed).sample(mutants, min(asked.sample, len(mutants)))
    survived = _survivors(mutants, {p: SAFETY_CORE[p] for p in paths}, asked.workers)
    # A line may have a change twice, of which one is equivalent: a sample may lack that one.
    seen = {key for key, count in Counter(map(_key, mutants)).items() if count == keys[key]}
    for mutant in survived:
        if _key(mutant) not in listed:
            wrong.append(f"survived: {mutant.path}:{mutant.line} | {mutant.change}")
    alive = set(map(_key, survived))
    wrong += [f"killed: {' | '.join(key)}" for key in sorted(listed & seen - alive)]
    total, left = (Counter(mutant.path for mutant in some) for some in (mutants, survived))
    for path in sorted(total):
        print(f"{path:48}{total[path]:5} mutants{total[path] - left[path]:5} killed")  # noqa: T201
    print(*wrong, sep="\n")  # noqa: T201
    seconds = time.monotonic() - began
    print(f"{len(mutants)} mutants, {len(survived)} survived, {seconds:.0f} s")  # noqa: T201
    return 1 if wrong else 0


def _key(mutant):
    return mutant.path, mutant.text, mutant.change


def _survivors(mutants, tests, workers):
    """Return the mutants that live: tried in warm code first, then imported in place of it."""
    for name in _HEAVY:
        importlib.import_module(name)
    import trial

    found = trial.try_warm([mutant for mutant in mutants if mutant.inside], tests, workers)
    warm = iter(found)
    left = [mutant for mutant in mutants if not mutant.inside or next(warm) != trial.KILLED]
    if left and trial.try_fresh(left[0]._replace(number=-1), tests[left[0].path]) == trial.KILLED:
        sys.exit("the tests fail in a fresh process without any mutant")
    works = [partial(trial.try_fresh, mutant, tests[mutant.path]) for mutant in left]
    found = trial.spread(works, workers)
    return [mutant for mutant, end in zip(left, found, strict=True) if end != trial.KILLED]


if __name__ == "__main__":
    sys.exit(main())
