"""Who waits is told of it, by nobody who is there when the waiting is over."""

import threading

from rig.cli import patience


def test_nobody_is_left_when_it_is_over(monkeypatch):
    monkeypatch.setattr(patience, "is_terminal", lambda stream: True)
    before = threading.active_count()
    for _ in range(50):
        with patience.told_if_long("waiting"):
            assert threading.active_count() == before + 1
        assert threading.active_count() == before
