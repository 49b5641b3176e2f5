"""What `rig check` names as the next command for gains that came with another rig's profile."""

import pytest

from rig.cli import inherited


@pytest.mark.parametrize(
    ("laws", "command"),
    [
        (["pid", "pid-friction", "cascade"], "rig tune lab.yaml"),
        (["pid", "pid-friction"], "rig tune lab.yaml --controller pid"),
        (["super-twisting"], "rig tune lab.yaml --controller super-twisting"),
    ],
)
def test_the_next_command_tunes_a_law_that_nobody_has_tuned(laws, command):
    class Lab:
        name, argument, calibration = "lab", "lab.yaml", None

    said = inherited._sentence(Lab, "cylinder", ["bore is 16 mm"], [], laws)
    assert said.endswith(f"Next: {command}")
