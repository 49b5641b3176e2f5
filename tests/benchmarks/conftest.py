"""Shows what was measured, below the tests: a table, and the same as one line of JSON."""

import json

import pytest

_TABLES = pytest.StashKey[list]()


@pytest.fixture
def table(request):
    """Return ``table(**row)``, which adds a row to this benchmark's table."""
    rows = []
    request.config.stash.setdefault(_TABLES, []).append((request.node.name, rows))
    return lambda **row: rows.append(row)


def pytest_terminal_summary(terminalreporter, config):
    """Write every table."""
    for name, rows in config.stash.get(_TABLES, []):
        if not rows:
            continue
        terminalreporter.section(name.removeprefix("test_").replace("_", " "), sep="-")
        for row in rows:
            cells = (f"{key} {_text(value)}" for key, value in row.items() if key != "what")
            terminalreporter.write_line(f"{row['what']:<44}" + "   ".join(cells))
        terminalreporter.write_line(json.dumps({"benchmark": name, "rows": rows}))


def _text(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)
