"""The table that a run prints: over which stretches of the motion a measure was taken."""

import json

import pytest

from rig.cli.run import _stretches

NAMES = ["all", "0.1 Hz", "0.1 Hz last lap", "0.2 Hz"]


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        ("0.2 Hz", "0.2 Hz"),
        ("0.? Hz", "0.1 Hz and 0.2 Hz"),
        ("0.1*", "0.1 Hz and 0.1 Hz last lap"),
        ("*", "*"),  # more than one reads in a line
        ("lap 7", "lap 7"),
    ],
)
def test_a_pattern_is_told_by_the_names_that_it_means(tmp_path, pattern, said):
    known = {"segments": [{"name": name} for name in NAMES]}
    (tmp_path / "evaluation.json").write_text(json.dumps(known))
    assert _stretches(tmp_path, pattern) == said


@pytest.mark.parametrize("text", [None, "", "[]", '{"segments": 3}'])
def test_a_folder_that_does_not_say_leaves_the_pattern(tmp_path, text):
    if text is not None:
        (tmp_path / "evaluation.json").write_text(text)
    assert _stretches(tmp_path, "0.? Hz") == "0.? Hz"
