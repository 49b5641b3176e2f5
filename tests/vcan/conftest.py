"""Tests on real SocketCAN interfaces; skipped, with the reason, where there are none."""

import pytest
from vcan_links import make_links


def pytest_collection_modifyitems(items):
    reason = None
    for item in items:
        if item.get_closest_marker("vcan"):
            reason = reason or make_links() or "ready"
            if reason != "ready":
                item.add_marker(
                    pytest.mark.skip(reason=f"{reason}; `python tests/vcan` boots one that has")
                )
