"""Commands with a package whose rows, or what is behind them, are not as they must be."""

import sys
from importlib.metadata import EntryPoint
from itertools import count

import pytest
from stranger_lab import SOURCE

from rig.assembly import offered, registry, rows
from rig.cli import invoke

CONFIGS = SOURCE / "crank_rig" / "configs"
GOOD = {
    "rig.mechanisms": {"crank": "crank_rig.crank.parts:PARTS"},
    "rig.drivers": {
        "tecno-regulator": "crank_rig.tecno.parts:PARTS",
        "load-cell": "crank_rig.load_cell.parts:PARTS",
    },
    "rig.additions": {"pi-for-cylinder": "crank_rig.extras.parts:FOR_CYLINDER"},
}
CACHES = (offered.mechanisms, offered.drivers, offered.protocols, offered.foreign_additions)
NUMBERS = count()
IMPORTS = """
import dataclasses
from crank_rig.crank import laws, mechanism, parts, references
from crank_rig.extras import pi
from crank_rig.tecno import device
from crank_rig.tecno import parts as tecno
from rig.hal.parts import Additions


def crank(**changed):
    return dataclasses.replace(parts.PARTS, **{k: f"{__name__}:{v}" for k, v in changed.items()})


def crank_with(**changed):
    return dataclasses.replace(
        parts.PARTS,
        **{
            k: {**parts.PARTS.controllers, "cross-coupled": f"{__name__}:{v}"}
            if k == "controllers"
            else (f"{__name__}:{v}",)
            for k, v in changed.items()
        },
    )
"""


@pytest.fixture
def plug_in(tmp_path, monkeypatch, capsys):
    """Return what runs a command with a package of one module in the place of a good row."""
    monkeypatch.syspath_prepend(SOURCE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)

    def run(group, name, code, *command, value=None, also=(), configs=CONFIGS):
        module = f"broken_{next(NUMBERS)}"
        (tmp_path / f"{module}.py").write_text(IMPORTS + code)
        offered = {kind: dict(points) for kind, points in GOOD.items()}
        offered[group][name] = value or f"{module}:PARTS"

        def entry_points(*, group):
            found = [EntryPoint(n, v, group) for n, v in offered.get(group, {}).items()]
            return [*found, *(EntryPoint(n, v, g) for g, n, v in also if g == group)]

        monkeypatch.setattr(rows, "entry_points", entry_points)
        monkeypatch.setattr("rig.assembly.contract_check.entry_points", entry_points)
        for cache in CACHES:
            cache.cache_clear()
        registry._TWICE.clear()
        exit_code = invoke([*command, *(["--configs", str(configs)] if configs else [])])
        captured = capsys.readouterr()
        assert "This is a bug in rig" not in captured.err, captured.err
        assert exit_code != 70, captured.err
        return exit_code, captured.err, module

    yield run
    for cache in CACHES:
        cache.cache_clear()
    registry._TWICE.clear()
    for name in [name for name in sys.modules if name.startswith(("broken_", "crank_rig"))]:
        del sys.modules[name]
