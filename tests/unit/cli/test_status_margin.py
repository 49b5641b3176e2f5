"""`rig status` says where tuned gains missed their margin."""

from types import SimpleNamespace

import pytest

from rig.cli.status import _margin_missed


@pytest.mark.parametrize(
    ("kept", "is_said"),
    [("94.5 % of 200 plants", True), ("100.0 % of 200 plants", False), ("", False), ("?", False)],
)
def test_a_margin_that_was_missed_is_said_with_what_measures_it(kept, is_said):
    conditions = {"sensitivity kept": kept} if kept else {}
    gains = SimpleNamespace(provenance=SimpleNamespace(conditions=conditions))
    said = _margin_missed(gains, "lab.yaml")
    assert (f"only {kept} keep" in said and "rig margins lab.yaml" in said) is is_said
