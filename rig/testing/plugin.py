"""The pytest plug-in: what fails in a suite is shown as if it stood in one's own test."""

import pytest

pytest.register_assert_rewrite(
    "rig.testing.devices",
    "rig.testing.laws",
    "rig.testing.mechanisms",
    "rig.testing.motions",
    "rig.testing.plants",
)
