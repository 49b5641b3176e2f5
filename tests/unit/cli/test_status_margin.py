"""`rig status` says where tuned gains missed their margin, and what looks for better ones."""

from types import SimpleNamespace

import pytest

from rig.cli.milestones import margin_missed


@pytest.mark.parametrize(
    ("kept", "is_said"),
    [
        ("94.5 % of 200 plants", True),
        ("94.5 % of 200 plants, measured", True),
        ("100.0 % of 200 plants", False),
        ("", False),
        ("?", False),
    ],
)
@pytest.mark.parametrize(
    ("wanted", "option"), [("sines and holds", ""), ("cylinder-step", " --for cylinder-step")]
)
def test_a_margin_that_was_missed_is_said_with_what_may_mend_it(kept, is_said, wanted, option):
    conditions = {"sensitivity kept": kept, "generations": "30", "tuned for": wanted}
    gains = SimpleNamespace(provenance=SimpleNamespace(conditions=conditions))
    said, better = margin_missed("pid", gains, "lab.yaml")
    command = f"rig tune lab.yaml --controller pid{option} --generations 60"
    assert better == (command if is_said else "")
    assert ("only 94.5 % of 200 plants keep" in said) is is_said
    assert ("(measured)" in said) is (is_said and kept.endswith("measured"))
