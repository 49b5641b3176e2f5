"""The figure of limits: every cut command with its channel, in each run in which one was cut."""

import csv
import io
import json
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rig.hal.columns import Column
from rig.report.limits_figure import draw_limits, table_of_limits
from rig.report.regenerate import write_report
from rig.run_facts import EVALUATION

MakeRun = Callable[..., Path]
T = np.arange(10) * 0.5


class FakeLog(dict[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]):
    """Columns by name."""

    t = T + 3.0  # the log's clock

    @property
    def columns(self) -> list[Column]:
        return [Column(name, "Pa", "of the test") for name in self]

    def column(self, name: str) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
        return self[name]


def tell(folder: Path, *told: tuple[float, str, int]) -> None:
    with (folder / "events.jsonl").open("a") as events:
        for t, message, hits in told:
            said = {"t": t, "kind": "limit", "message": message, "data": {"hits": hits}}
            events.write(json.dumps(said) + "\n")


@pytest.fixture
def run(tmp_path: Path) -> SimpleNamespace:
    """Return a run in which one of two channels is cut in cycles 2, 3 and 7."""
    wanted = 1e5 + 1e4 * np.sin(T)
    applied = wanted * (1.0 + 1e-13)  # rounding alone
    applied[[2, 3, 7]] = 0.9e5
    log = FakeLog({
        "command.agonist": wanted, "applied.agonist": applied,
        "command.antagonist": wanted, "applied.antagonist": wanted, "command.estimate": wanted,
    })  # fmt: skip
    (tmp_path / "events.jsonl").touch()
    return SimpleNamespace(folder=SimpleNamespace(path=tmp_path), log=log, t=T)


def test_every_cut_cycle_is_in_the_table(run: SimpleNamespace) -> None:
    tell(run.folder.path, (4.0, "pressure range is limited", 2))
    tell(run.folder.path, (5.0, "pressure range was limited in 3 cycles of the run", 3))
    rows = list(csv.DictReader(io.StringIO("".join(table_of_limits(run)))))
    assert [float(row["time (s)"]) for row in rows] == [T[2], T[3], T[7]]
    assert {row["channel"] for row in rows} == {"agonist"}
    assert {row["limit"] for row in rows} == {"pressure range"}
    assert {(float(row["bound"]), row["unit"]) for row in rows} == {(0.9e5, "Pa")}
    wanted = run.log["command.agonist"]
    assert [float(row["value"]) for row in rows] == pytest.approx(wanted[[2, 3, 7]])


def test_a_long_run_takes_no_more_memory_for_its_table(run: SimpleNamespace) -> None:
    """Every command of 400,000 cycles is cut: the whole table would be 40 MB and more."""
    count = 400_000
    run.t = np.arange(count) * 1e-3
    wanted = np.full(count, 1e5)
    run.log = FakeLog({"command.agonist": wanted, "applied.agonist": wanted - 1.0})
    tracemalloc.start()
    try:
        lines = sum(piece.count("\n") for piece in table_of_limits(run))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert lines == 1 + count
    assert most < 8e6


def test_the_pieces_of_a_table_leave_out_nothing_at_their_ends(
    run: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    run.log["applied.antagonist"] = run.log["applied.agonist"]
    whole = "".join(table_of_limits(run))
    assert [row.split(",")[2] for row in whole.splitlines()[1:3]] == ["agonist", "antagonist"]
    for size in (1, 3, 4, 10):
        monkeypatch.setattr("rig.report.limits_figure._PIECE", size)
        assert "".join(table_of_limits(run)) == whole


def test_stretches_are_bars_beside_when_each_limit_began(run: SimpleNamespace) -> None:
    assert draw_limits(run) is None
    tell(run.folder.path, (4.0, "pressure range is limited", 2), (4.5, "pair force is limited", 1))
    figure = draw_limits(run)
    assert figure is not None
    (axes,) = figure.axes
    told = [label.get_text() for label in axes.get_yticklabels()]
    assert told == ["pressure range: 2 cycles", "pair force: 1 cycles", "agonist: 3 cycles"]
    (bars,) = axes.collections
    spans = [path.get_extents() for path in bars.get_paths()]
    assert [(span.x0, span.x1) for span in spans] == [(T[2], T[4]), (T[7], T[8])]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "begins to cut", "command is cut",
    ]  # fmt: skip
    assert axes.lines[0].get_xdata() == pytest.approx([1.0])  # the log's clock shifted


@pytest.mark.parametrize("is_cut", [True, False])
def test_whoever_asked_for_other_figures_gets_it_where_anything_was_cut(
    make_run: MakeRun, *, is_cut: bool
) -> None:
    folder = make_run(duration=2.0)
    file = folder / EVALUATION
    file.write_text(json.dumps({**json.loads(file.read_text()), "figures": ["error"]}))
    if is_cut:
        tell(folder, (1.0, "pressure range is limited", 2))
    report = write_report(folder)
    assert (folder / "figures" / "limits.png").exists() == is_cut
    assert (folder / "figures" / "error.png").exists()
    assert report.notes == []
