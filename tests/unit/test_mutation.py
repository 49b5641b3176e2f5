"""The tool that changes the safety core finds every change there is, and what survives."""

import subprocess
import sys

import pytest
from safety_core import ROOT, SAFETY_CORE

sys.path.append(str(ROOT / "tests" / "mutation"))

from changes import mutants_of
from equivalents import EQUIVALENTS

CHANGES = [
    ("a < b", ["a < b -> a <= b", "a < b -> a >= b"]),
    ("a <= b < c", [
        "a <= b < c -> a < b < c", "a <= b < c -> a > b < c",
        "a <= b < c -> a <= b <= c", "a <= b < c -> a <= b >= c",
    ]),
    ("a == b", ["a == b -> a != b"]),
    ("a is None", ["a is None -> a is not None"]),
    ("a not in b", ["a not in b -> a in b"]),
    ("a and not b", ["a and (not b) -> a or not b", "not b -> b"]),
    ("a + b * c", ["a + b * c -> a - b * c", "b * c -> b / c"]),
    ("-a % b", ["-a % b -> -a * b", "-a -> a"]),
    ("0", ["0 -> 1"]),
    ("2.5", ["2.5 -> 5.0"]),
    ("0.5", ["0.5 -> 1.5"]),
    ("True", ["True -> False"]),
    ("min(abs(a), b)", ["min(abs(a), b) -> max(abs(a), b)", "abs(a) -> a"]),
    ("a if b else c", ["b -> True", "b -> False"]),
    ("[a for a in b if c]", ["c -> True"]),
    ("'words'", []),
    ("f'{a:.3f}'", []),
    ("zip(a, b, strict=True)", []),
]  # fmt: skip
"""What may become of an expression."""

STATEMENTS = [
    ("a()", ["a() -> pass"]),
    ("'words'", []),
    ("a = b", []),
    ("a.b = c", ["a.b = c -> pass"]),
    ("a.b: int = c", ["a.b: int = c -> pass"]),
    ("a += b", ["a += b -> pass", "a += b -> a -= b"]),
    ("raise a", ["raise a -> pass"]),
    ("return a", ["return a -> return None"]),
    ("return", []),
    ("while a: b()", ["a -> False", "b() -> pass"]),
]


def changes(tmp_path, source):
    (tmp_path / "one.py").write_text(source)
    return mutants_of(tmp_path, "one.py")


@pytest.mark.parametrize(("expression", "expected"), CHANGES)
def test_every_change_of_an_expression(tmp_path, expression, expected):
    found = changes(tmp_path, f"def f(x: int = 7):\n    it = {expression}\n")
    assert found[0].change == "7 -> 8" and not found[0].inside
    assert [mutant.change for mutant in found[1:]] == expected
    assert all(mutant.inside and mutant.line == mutant.last == 2 for mutant in found[1:])


@pytest.mark.parametrize(("statement", "expected"), STATEMENTS)
def test_every_change_of_a_statement(tmp_path, statement, expected):
    found = changes(tmp_path, f"def f():\n    {statement}\n")
    assert [mutant.change for mutant in found] == expected


def test_a_mutant_has_its_one_change(tmp_path):
    source = "def f(a):\n    if a > 1:\n        return a + 5\n    return -a\n"
    found = changes(tmp_path, source)
    made = set()
    for mutant in found:
        space = {}
        exec(compile(mutant.tree(), "one.py", "exec"), space)
        made.add(tuple(space["f"](a) for a in (0, 1, 2, 3)))
    assert len(found) == len(made) == 10
    assert (0, -1, 7, 8) not in made  # what it was


def test_each_equivalent_is_a_mutant_of_the_core():
    mutants = {
        (mutant.path, mutant.text, mutant.change)
        for path in {one.path for one in EQUIVALENTS}
        for mutant in mutants_of(ROOT, path)
    }
    assert {one[:3] for one in EQUIVALENTS} <= mutants
    assert {one.path for one in EQUIVALENTS} <= set(SAFETY_CORE)
    assert len(EQUIVALENTS) == len(set(EQUIVALENTS))


def _python(*words):
    return subprocess.run(
        [sys.executable, *words], cwd=ROOT, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_of_a_sample_of_mutants_none_survives():
    done = _python("tests/mutation", "--sample", "60", "--seed", "20261122")
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


@pytest.mark.slow
def test_the_tests_of_each_file_of_the_core_run_every_line_and_branch():
    done = _python("tests/safety_core.py")
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
