"""The report: complete, offline, and made from the folder alone, whatever became of the run."""

import json
import re
import shutil
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rig.hal import ConfigurationError
from rig.report import style
from rig.report.regenerate import write_report
from rig.run_facts import RunStatus
from rig.run_folder import RunFolder

MakeRun = Callable[..., Path]


class Page(HTMLParser):
    """Collects what a browser would fetch, the text, and whether the tags match."""

    VOID = ("meta", "img", "br", "link")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.links: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        assert self.open == [], "every tag is closed"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag not in ("script", "iframe", "link")
        values = dict(attrs)
        self.sources += [values["src"] or ""] if "src" in values else []
        self.links += [values["href"] or ""] if "href" in values else []
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(autouse=True)
def _draw_plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the layout, which takes most of the time: figures have tests of their own."""
    monkeypatch.setitem(style._RC, "figure.constrained_layout.use", False)
    monkeypatch.setitem(style._RC, "savefig.dpi", 50)


def test_report_says_everything_and_fetches_nothing(make_run: MakeRun) -> None:
    run = make_run(status=RunStatus.FAILED, bound=0.5e-4)
    report = write_report(run).page
    assert report == run / "report.html"
    text = report.read_text()
    page = Page(text)
    assert len(page.sources) == 5
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert all((run / link).is_file() for link in page.links), "links stay in the folder"
    outside = re.sub(r"base64,[A-Za-z0-9+/=]+", "", text)
    assert not re.search(r"https?:|//[a-z]|url\(|@import", outside)
    for expected in (
        "cylinder-sine on virtual", "failed", "tracking_rms", "≤ 0.05 mm", "fail", "pass",
        "0.2 Hz", "stage to blame", "transmit", "idle → running",
        "rate of <agonist> & antagonist limited", "rig run cylinder-sine --set 'a.b=<c>'",
        "numpy", "SHA-256", "2026-11-21 03:45:12 UTC", "seed",
    ):  # fmt: skip
        assert expected in page.text, expected
    assert "<agonist>" not in text, "what comes from outside is escaped"


def test_what_was_planned_is_told_if_the_folder_has_it(make_run: MakeRun) -> None:
    run = make_run(duration=2.0)
    assert "as it was planned" not in write_report(run).page.read_text()
    content = json.loads((run / "evaluation.json").read_text())
    content["remarks"] = [{"kind": "elbow, 1.250 s", "message": "through: the <arm> is stretched"}]
    (run / "evaluation.json").write_text(json.dumps(content))
    page = write_report(run).page.read_text()
    assert "elbow, 1.250 s" in page and "through: the &lt;arm&gt; is stretched" in page
    content["remarks"] = ["elbow"]
    (run / "evaluation.json").write_text(json.dumps(content))
    with pytest.raises(ConfigurationError, match="remarks"):
        write_report(run)


def test_report_regenerates_what_was_lost(make_run: MakeRun) -> None:
    run = make_run()
    metrics = (run / "metrics.json").read_bytes()
    timing = (run / "timing.json").read_bytes()
    (run / "metrics.json").unlink()
    (run / "timing.json").unlink()
    write_report(run)
    assert (run / "metrics.json").read_bytes() == metrics
    assert (run / "timing.json").read_bytes() == timing
    assert (run / "figures" / "tracking.svg").exists()


def test_killed_run_is_reported_as_far_as_it_went(make_run: MakeRun) -> None:
    run = make_run(duration=10.0, status=None)
    log = run / "log.mcap"
    content = log.read_bytes()
    log.write_bytes(content[: int(len(content) * 0.85)])
    page = Page(write_report(run).page.read_text())
    assert RunFolder.open(run).status is RunStatus.CRASHED
    assert len(page.sources) == 5, "a killed run has all its figures"
    assert "crashed" in page.text and "process died" in page.text
    names = [m["name"] for m in json.loads((run / "metrics.json").read_text())["metrics"]]
    assert names == ["tracking_rms"], "only the segment that was finished is judged"
    assert "segment '0.5 Hz' lasts from" in page.text


def test_run_without_a_log_is_reported(make_run: MakeRun) -> None:
    run = make_run(duration=1.0, status=None)
    (run / "log.mcap").unlink()
    shutil.rmtree(run / "figures", ignore_errors=True)
    page = Page(write_report(run).page.read_text())
    assert "cannot read the log" in page.text and page.sources == []


def test_live_run_is_left_alone(make_run: MakeRun, tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "live", "sine", "hardware", inputs={})
    source = make_run(duration=1.0)
    shutil.copy(source / "log.mcap", run.log_path)
    page = Page(write_report(run.path).page.read_text())
    assert "still goes on" in page.text
    assert not (run.path / "metrics.json").exists()
    run.finish(RunStatus.ABORTED, 130)


def test_other_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="not a run folder"):
        write_report(tmp_path)


@pytest.mark.parametrize("passed", [None, False])
def test_a_measure_whose_package_is_gone_keeps_its_verdict(make_run, passed):
    run = make_run(duration=2.0)
    metrics = json.loads((run / "metrics.json").read_text())
    row = {**metrics["metrics"][0], "name": "gone", "measure": "gone", "value": None, "bound": 1.0}
    metrics["metrics"].append({**row, "bound_kind": "max", "pass": passed})
    (run / "metrics.json").write_text(json.dumps(metrics))
    evaluation = json.loads((run / "evaluation.json").read_text())
    asked = {"measure": None, "segments": "*", "max": 1.0, "min": None}
    evaluation["metrics"]["gone"] = asked
    (run / "evaluation.json").write_text(json.dumps(evaluation))
    write_report(run)
    again = json.loads((run / "metrics.json").read_text())["metrics"]
    assert next(m for m in again if m["name"] == "gone")["pass"] is passed
