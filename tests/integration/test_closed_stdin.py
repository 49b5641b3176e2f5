"""Commands whose standard input was closed (`<&-`) ask nobody, and say so."""

import sys

import pytest

from rig.cli import invoke


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["new", "rig", "named"], 0, "rig named is written"),
        (["calibrate", "cylinder", "regulators"], 2, "no terminal to ask: say --yes"),
        (["commission", "cylinder", "--on", "hardware"], 2, "no terminal to ask: say --yes"),
    ],
)
def test_nobody_is_asked(tmp_path, monkeypatch, capsys, words, code, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdin", None)
    assert invoke(words) == code
    assert said in capsys.readouterr().err
