"""What plain ``pytest`` leaves out: tests that take long or measure, unless they are asked for."""

APART = ("benchmark", "slow")


def pytest_collection_modifyitems(config, items):
    """Deselect marked tests whose marker the ``-m`` expression does not speak of."""
    asked = config.option.markexpr
    apart = [marker for marker in APART if marker not in asked]
    left_out = [item for item in items if any(item.get_closest_marker(m) for m in apart)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in set(left_out)]
