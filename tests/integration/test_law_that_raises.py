"""What a law of another package raises is said with its line, whichever call it was."""

from pathlib import Path

import pytest

LAW = """
class Odd(laws.CrossCoupled):
    calls = 0
    def update(self, state, reference):
        Odd.calls += 1
        if Odd.calls == {call}:
            {statement}
        return super().update(state, reference)
PARTS = crank_with(controllers='Odd')
"""
STATEMENTS = {
    "ZeroDivisionError": "1 / 0",
    "AttributeError": "self.gian",
    "KeyError": "{}['gain']",
    "TypeError": "'a' + 1",
}


@pytest.mark.parametrize("call", [1, 2, 10])
@pytest.mark.parametrize("kind", STATEMENTS)
def test_an_exception_of_a_law_is_said_with_its_line(plug_in, kind, call):
    code = LAW.format(call=call, statement=STATEMENTS[kind])
    command = ("run", "crank-turns", "--on", "sim", "--no-report")
    exit_code, said, module = plug_in(("rig.mechanisms"), "crank", code, *command)
    assert exit_code == 2
    assert f"{module}, line " in said
    assert f"{kind}: " in said
    assert "returned None" not in said
    shown = said.splitlines()
    files = [line.split('"')[1] for line in shown if line.lstrip().startswith('File "')]
    assert files, said
    assert all(Path(file).stem.startswith(("broken_", "laws")) for file in files), said
    (kept,) = [line for line in shown if line.startswith("the whole traceback: ")]
    whole = Path(kept.removeprefix("the whole traceback: ")).read_text()
    assert whole.startswith("Traceback (most recent call last):")
    assert "/rig/runtime/" in whole and f"{kind}: " in whole


def test_an_attribute_that_a_state_has_not_is_told_with_those_that_it_has(plug_in):
    code = LAW.format(call=2, statement="state.psition")
    command = ("run", "crank-turns", "--on", "sim", "--no-report")
    _, said, _ = plug_in("rig.mechanisms", "crank", code, *command)
    last = said.rstrip().splitlines()[-1]
    assert last.startswith("error: "), said
    assert "has no attribute 'psition'" in last and "; it has: " in last, last
