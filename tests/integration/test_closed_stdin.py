"""Commands whose standard input was closed (`<&-`) ask nobody, and say so."""

import sys

import pytest

from rig.cli import invoke

COMMISSION = ["commission", "cylinder", "--on", "hardware"]
BUILT = "cylinder.limits.stop_energy=20 J"


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["new", "rig", "named"], 0, "rig named is written"),
        (["calibrate", "cylinder", "regulators"], 2, "no terminal to ask: say --yes"),
        ([*COMMISSION, "--set", BUILT], 2, "no terminal to ask: say --yes"),
        (COMMISSION, 3, "limits.stop_energy"),
    ],
)
def test_nobody_is_asked(tmp_path, monkeypatch, capsys, words, code, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdin", None)
    assert invoke(words) == code
    assert said in capsys.readouterr().err
