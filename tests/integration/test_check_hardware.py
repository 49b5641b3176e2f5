"""`rig check` ends with what hardware would refuse of a profile that is valid."""

import json

import pytest

import rig
from rig.cli import invoke

STOP = "cylinder.limits.stop_energy=1 J"
SLOW = ["buses.can0.heartbeat=90 ms", "buses.can0.heartbeat_timeout=190 ms"]


def sets(options):
    return [word for option in options for word in ("--set", option)]


@pytest.mark.parametrize(
    ("source", "options", "told"),
    [
        ("cylinder", [], ["limits.stop_energy is not declared"]),
        ("cylinder", [STOP], []),
        ("cylinder-sine", [STOP, *SLOW], ["keeps its setpoints for 190 ms"]),
        ("cylinder-sine", SLOW, ["Give the energy that the stop bears", "shorten its heartbeat"]),
        ("cylinder-sine", [STOP, "controller=pid"], ["reason is given: --set 'loop.small_margin"]),
        ("cylinder-sine", [STOP, "controller=pid", "loop.small_margin=it is held"], []),
    ],
)
def test_check_says_in_a_line_each_what_hardware_would_refuse(capsys, source, options, told):
    assert invoke(["check", source, *sets(options)]) == 0
    before, valid, after = capsys.readouterr().err.partition(f"{source}: valid\n")
    assert valid
    lines = after.splitlines()
    assert len(lines) == len(told), after
    for line, words in zip(lines, told, strict=True):
        assert line.startswith("hardware would refuse it: ")
        assert words in line
    assert ("rig check EXPERIMENT" in before) is (source == "cylinder")
    assert invoke(["check", source, *sets(options), "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["refused_on_hardware"]
    assert [f"hardware would refuse it: {sentence}" for sentence in listed] == lines


def test_a_program_is_told_the_same():
    (said,) = rig.check("cylinder-sine", set={"cylinder.limits.stop_energy": 1.0, **late()})[
        "refused_on_hardware"
    ]
    assert "keeps its setpoints for 190 ms" in said


def late():
    return {"buses.can0.heartbeat": 0.09, "buses.can0.heartbeat_timeout": 0.19}


@pytest.mark.parametrize("words", [["run", "cylinder-sine"], ["margins", "cylinder"]])
def test_a_run_on_hardware_is_refused_with_all_that_check_lists(
    tmp_path, monkeypatch, capsys, words
):
    monkeypatch.chdir(tmp_path)
    own = ["--on", "hardware", "--yes", "cylinder", *sets(SLOW)]
    assert invoke([*words, *own]) == 3
    lines = capsys.readouterr().err.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("error: "))
    assert "Give the energy that the stop bears" in lines[first]
    others = [line for line in lines[first + 1 :] if line.startswith("refused as well: ")]
    assert any("shorten its heartbeat" in line for line in others), lines
    if words[0] == "run":
        assert invoke(["check", words[1], *sets(SLOW)]) == 0
        listed = capsys.readouterr().err.splitlines()
        listed = [line.partition(": ")[2] for line in listed if line.startswith("hardware would")]
        told = [line.partition(": ")[2] for line in (lines[first], *others)]
        assert told == listed
