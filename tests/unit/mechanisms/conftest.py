"""What tests of mechanisms share."""

import pytest

from rig.mechanisms.pneumatic.alarms.missing import UnseenPull


@pytest.fixture
def moved_by_hand(monkeypatch):
    """Have nobody mind that rods go where no pressure drives them."""
    monkeypatch.setattr(UnseenPull, "lasts", False)
