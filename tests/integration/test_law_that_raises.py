"""What a law of another package raises is said with its line, whichever call it was."""

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
