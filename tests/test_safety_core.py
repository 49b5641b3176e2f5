"""The list of the files that decide on safety names what there is."""

import pytest
from safety_core import ROOT, SAFETY_CORE


@pytest.mark.parametrize("path", SAFETY_CORE)
def test_each_file_of_the_safety_core_has_tests_of_its_own(path):
    assert (ROOT / path).is_file()
    assert SAFETY_CORE[path]
    for name in SAFETY_CORE[path]:
        assert (ROOT / "tests" / "unit" / name).is_file()


@pytest.mark.parametrize("folder", ["rig/mechanisms/pneumatic/alarms", "rig/mechanisms/servo"])
def test_whatever_raises_in_a_folder_of_checks_is_of_the_safety_core(folder):
    raising = {
        str(path.relative_to(ROOT))
        for path in (ROOT / folder).glob("*.py")
        if "raise SafetyError" in path.read_text() or "raise LimitExceeded" in path.read_text()
    }
    assert raising
    assert raising <= set(SAFETY_CORE)
