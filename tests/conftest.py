"""What plain ``pytest`` leaves out, and how many processes share the work."""

import os

APART = ("benchmark", "slow")


def pytest_collection_modifyitems(config, items):
    """Deselect marked tests whose marker the ``-m`` expression does not speak of."""
    asked = config.option.markexpr
    apart = [marker for marker in APART if marker not in asked]
    left_out = [item for item in items if any(item.get_closest_marker(m) for m in apart)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in set(left_out)]


def pytest_xdist_auto_num_workers(config):
    """Measure alone, and test on every core."""
    return 0 if "benchmark" in config.option.markexpr else os.cpu_count()
