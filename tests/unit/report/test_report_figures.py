"""Figures: drawn from the folder alone, not empty, and honest about peaks."""

import csv
import json
import math
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.image import imread

from rig.hal import ConfigurationError
from rig.mechanisms.cylinder.figures import PAIR_FIGURES, draw_error
from rig.report.compare import compare_metrics, draw_comparison
from rig.report.data import load_run
from rig.report.envelope import envelope, path_envelope
from rig.report.figures import draw_figures
from rig.report.style import format_length, paper_style
from rig.report.timing import STAGES, summarise_timing
from rig.report.timing_figure import TIMING_FIGURES
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder, RunFolderError
from rig.runtime.recorder import LogRecorder

MakeRun = Callable[..., Path]


def ink(path: Path) -> float:
    """Share of the pixels that are not white."""
    return float(np.mean(np.any(imread(path)[..., :3] < 0.98, axis=-1)))


def test_every_figure_is_drawn_as_png_and_svg(make_run: MakeRun) -> None:
    run = make_run()
    paths = draw_figures(run).files
    # The others need columns that a pair has not, or a level that is gone to again.
    drawn = {*PAIR_FIGURES, *TIMING_FIGURES} - {"repeatability"}
    assert {p.name for p in paths} == {
        f"{n}.{s}" for n in drawn for s in ("png", "svg", "pdf", "csv")
    }
    for path in paths:
        assert path.parent == run / "figures"
        if path.suffix == ".png":
            assert ink(path) > 0.02
            width_mm = imread(path).shape[1] / 220 * 25.4
            assert min(abs(width_mm - 85), abs(width_mm - 170)) < 0.5
        elif path.suffix == ".svg":
            assert ElementTree.parse(path).getroot().tag.endswith("svg")


def test_same_run_gives_the_same_bytes(make_run: MakeRun) -> None:
    run = make_run(duration=2.0)
    first = [path.read_bytes() for path in draw_figures(run, ["tracking", "error"]).files]
    again = [path.read_bytes() for path in draw_figures(run, ["tracking", "error"]).files]
    assert first == again


def test_unwritable_folder_is_named(make_run: MakeRun) -> None:
    run = make_run(duration=2.0)
    (run / "figures").write_text("in the way")
    with pytest.raises(RunFolderError, match=r"cannot write figures to .*figures"):
        draw_figures(run, ["tracking"])


def test_unknown_figure_is_named(make_run: MakeRun) -> None:
    with pytest.raises(ConfigurationError, match=r"'speed'.*tracking"):
        draw_figures(make_run(duration=2.0), ["speed"])


def test_error_figure_shows_error_bounds_and_units(make_run: MakeRun) -> None:
    run = load_run(make_run(error=2e-4))
    with paper_style():
        figure = draw_error(run)
    assert figure is not None
    axes = figure.axes[0]
    assert axes.get_ylabel() == "error (mm)"
    assert axes.get_xlabel().endswith("(s)")
    drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
    peak = np.abs(run.error[run.followed]).max() * 1e3
    assert np.abs(drawn).max() == pytest.approx(peak)
    low, high = axes.get_ylim()
    assert low < -0.3 and high > 0.3, "the bound of 0.3 mm is in view"
    levels = {round(float(abs(p[0, 1])), 6) for c in axes.collections for p in c.get_segments()}
    assert levels == {0.15, 0.3}
    texts = [text.get_text() for text in axes.texts]
    assert len(texts) == 3 and all("Hz" in text for text in texts)


def test_segments_that_were_not_reached_are_not_labelled(make_run: MakeRun) -> None:
    path = make_run(status=None)
    content = (path / "log.mcap").read_bytes()
    for share, expected in ((0.4, ["0.1 Hz\nincomplete"]), (0.7, ["0.1 Hz\nrms", "0.2 Hz\ninc"])):
        (path / "log.mcap").write_bytes(content[: int(share * len(content))])
        run = load_run(path)
        with paper_style():
            figure = draw_error(run)
        assert figure is not None
        axes = figure.axes[0]
        texts = [text.get_text() for text in axes.texts]
        assert len(texts) == len(expected)
        assert all(text.startswith(start) for text, start in zip(texts, expected, strict=True))
        left, right = axes.get_xlim()
        assert all(left < text.xy[0] < right for text in axes.texts)


def test_envelope_keeps_every_peak_and_its_order() -> None:
    t = np.linspace(0.0, 1.0, 100_003)
    x = np.sin(2 * np.pi * 5000.0 * t)
    x[[777, 55_555, 100_002]] = [9.0, -8.0, 7.0]
    short_t, short_x = envelope(t, x, 2000)
    assert len(short_t) <= 2000
    assert {9.0, -8.0, 7.0} <= set(short_x.tolist())
    assert np.all(np.diff(short_t) >= 0.0)
    assert np.all(np.isin(short_t, t))
    assert np.ptp(short_x[(short_t > 0.1) & (short_t < 0.2)]) > 1.99, "no folding"
    assert envelope(t[:50], x[:50], 2000)[0] is not None
    assert np.array_equal(envelope(t[:50], x[:50], 2000)[1], x[:50])


def test_a_long_path_is_drawn_wherever_it_is_once() -> None:
    angle = np.linspace(0.0, 2e3 * np.pi, 1_000_003)
    x, y = np.cos(angle), np.sin(angle)
    x[[777, 555_555]], y[999_999] = (1.9, 1.7), -3.0
    short_x, short_y = path_envelope(x, y)
    assert len(short_x) == len(short_y) < 20_000
    assert {1.9, 1.7} <= set(short_x.tolist())
    assert -3.0 in short_y
    at = np.flatnonzero(short_x == 1.7)[0]
    assert short_x[at - 1 : at + 2].tolist() == x[555_554:555_557].tolist(), "there and back"
    seen = np.angle(short_x + 1j * short_y)
    assert np.diff(np.sort(seen[np.isfinite(seen)])).max() < 0.02, "all the way round"
    assert np.array_equal(path_envelope(x[:50_000], y[:50_000])[1], y[:50_000])


@pytest.mark.parametrize(
    ("value", "text"), [(83.2e-6, "83.2 µm"), (0.15e-3, "0.15 mm"), (0.0, "0 µm")]
)
def test_lengths_read_well(value: float, text: str) -> None:
    assert format_length(value) == text


def test_timing_names_the_stage_to_blame(make_run: MakeRun) -> None:
    run = load_run(make_run(duration=2.0))
    timing = summarise_timing(run.log)
    assert timing["period"] == pytest.approx(0.002)
    assert timing["cycles"] == len(run.log.t) and timing["missed"] == 0
    assert timing["overruns"] == 1
    worst = timing["worst"][0]
    assert worst["blame"] == "transmit" and worst["work"] > 2.5e-3
    assert worst["cycle"] == len(run.log.t) // 2
    assert sum(stage["share"] for stage in timing["stages"].values()) == pytest.approx(1.0)
    assert tuple(timing["stages"]) == STAGES
    gaps = run.log._replace(cycle=run.log.cycle * 3)
    assert summarise_timing(gaps)["missed"] == 2 * (len(run.log.t) - 1)
    untimed = run.log._replace(columns=run.log.columns[:3], values=run.log.values[:, :3])
    assert summarise_timing(untimed) == {}


def test_comparison_of_runs(make_run: MakeRun, tmp_path: Path) -> None:
    paths = [
        make_run("pid", error=3e-4, status=RunStatus.FAILED),
        make_run("cascade", error=0.5e-4),
        make_run("killed", duration=4.0, status=None),
    ]
    labels = ["pid", "cascade", "killed"]
    png, svg, *_ = draw_comparison(paths, labels, tmp_path / "compared")
    assert ink(png) > 0.02 and svg.exists()
    rows = compare_metrics(paths, labels)
    assert [row["name"] for row in rows] == [
        "tracking_rms", "tracking_max", "velocity_ripple", "pressure_max",
    ]  # fmt: skip
    pid, cascade, killed = rows[0]["values"]
    assert pid > 3 * cascade and killed is None
    assert (rows[0]["unit"], rows[0]["bound"], rows[0]["bound_kind"]) == ("m", 1.5e-4, "max")
    log = load_run(paths[1]).log
    (paths[1] / "log.mcap").unlink()
    with LogRecorder(paths[1] / "log.mcap", log.columns) as recorder:
        for k, row in enumerate(log.values[:3000].tolist()):
            recorder.write(k, float(log.t[k]), row)
        recorder.write(3000, float(log.t[3000]), [math.nan] * len(log.columns))
    assert np.isnan(load_run(paths[1]).error[-1])
    draw_comparison(paths, labels, tmp_path / "compared")  # a broken sensor's run too
    _, svg, *_ = draw_comparison(paths, labels, tmp_path / "less", {"esc": "refused"})
    assert "not drawn: esc (refused)" in svg.read_text()
    with pytest.raises(ConfigurationError, match="3 runs and 1 labels"):
        draw_comparison(paths, ["pid"], tmp_path)


def test_the_data_of_a_figure_lie_beside_it(make_run: MakeRun) -> None:
    run = make_run("pid")
    draw_figures(run, ["tracking"])
    with (run / "figures" / "tracking.csv").open() as table:
        rows = list(csv.DictReader(table))
    [measured] = [name for name in rows[0] if "reading" in name and "position" in name]
    values = [float(row[measured]) * 1e-3 for row in rows if row[measured]]
    position = load_run(run).trace("reading.position")
    assert min(values) == pytest.approx(position.min(), abs=1e-9)
    assert max(values) == pytest.approx(position.max(), abs=1e-9)
    pdf = (run / "figures" / "tracking.pdf").read_bytes()
    assert pdf.startswith(b"%PDF") and b"CreationDate" not in pdf


def test_a_figure_says_what_ran(make_run: MakeRun) -> None:
    run = make_run("pid")
    draw_figures(run, ["tracking"])
    manifest = RunFolder.open(run).manifest
    svg = (run / "figures" / "tracking.svg").read_text()
    assert manifest["experiment"] in svg and manifest["started"][:10] in svg


def test_limits_are_drawn_where_they_cut_and_nowhere_else(make_run: MakeRun) -> None:
    run = make_run(duration=2.0)
    assert draw_figures(run, ["limits"]).files == []
    with (run / "events.jsonl").open("a") as events:
        told = (
            (0.5, "pair force is limited", 2),
            (1.0, "setpoint rate is limited", 1),
            (1.5, "pair force is limited", 5),
            (1.9, "pair force was limited in 9 cycles of the run", 9),
        )
        for t, message, hits in told:
            said = {"t": t, "kind": "limit", "message": message, "data": {"hits": hits}}
            events.write(json.dumps(said) + "\n")
    drawn = draw_figures(run, ["limits"]).files
    assert {path.suffix for path in drawn} == {".png", ".svg", ".pdf", ".csv"}
    svg = next(path for path in drawn if path.suffix == ".svg").read_text()
    assert "pair force: 9 cycles" in svg
    assert "setpoint rate: 1 cycles" in svg
    assert "was limited" not in svg
    assert "begins to cut" in svg
