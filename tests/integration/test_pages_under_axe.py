"""Pages under axe-core in a real browser: reports, sweeps, campaigns, acceptance, `rig watch`."""

import shutil
import time
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from watched import served_folder, watched_run

from rig.cli import invoke
from rig.commissioning import page as acceptance

CHROMIUM = shutil.which("chromium")
if CHROMIUM is None:
    pytest.skip("there is no chromium: apt-get install chromium", allow_module_level=True)
sync_api = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="pip install '.[test]'")
pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[2] / "configs"
SIZES = ((1600, 900), (360, 800))
SCHEMES = ("light", "dark")
STOPPED = "simulation.faults=[{at: 3 s, device: regulators, fault: emergency_stop}]"
RUNS = {
    "cylinder": ["cylinder-step"], "joint": ["joint-range"], "arm": ["arm-elbow-turnback"],
    "legs": ["legs-squat"], "fault": ["cylinder-step", "--set", STOPPED],
}  # fmt: skip


@contextmanager
def looked_at(address):
    """Yield a page for each size of a screen and each colour scheme."""
    with sync_api.sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield (opened_page(opened, address, size, scheme) for size in SIZES for scheme in SCHEMES)
        opened.close()


def opened_page(opened, address, size, scheme):
    viewport = dict(zip(("width", "height"), size, strict=True))
    page = opened.new_context(viewport=viewport, color_scheme=scheme).new_page()
    page.goto(address)
    return page


def troubles(page):
    """Return what axe finds in a page, and whether one has to scroll sideways to read it."""
    found = [
        f"{kind['impact']} {kind['id']}: {node['html'][:120]}: {node['failureSummary']}"
        for kind in axe.Axe().run(page).response["violations"]
        for node in kind["nodes"]
    ]
    beyond = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    return found + [f"{beyond} pixels are beyond the screen"] * (beyond > 0)


def done(*words, codes=(0,)):
    assert invoke([str(word) for word in words]) in codes, words


def run_page(out, words, codes=(0,)):
    done("run", *words, "--on", "sim", "--out", out, codes=codes)
    (found,) = out.glob("*/report.html")
    return found


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return the report of a run of each rig, and of one that was stopped."""
    out = tmp_path_factory.mktemp("runs")
    codes = {"fault": (4,)}
    return {
        name: run_page(out / name, words, codes.get(name, (0,))) for name, words in RUNS.items()
    }


def calibrated(folder):
    configs = shutil.copytree(
        CONFIGS, folder / "configs", ignore=shutil.ignore_patterns("calibration", "commissioning")
    )
    words = ["--on", "sim", "--yes", "--configs", configs, "--out", folder]
    done("calibrate", "cylinder-uncalibrated", "encoders", *words)
    (run,) = folder.glob("*-calibrate-encoders-sim")
    done("report", run)
    return run / "report.html"


def swept(folder):
    words = ["--on", "sim", "--vary", "controller=pid,cascade", "--seeds", "0:2"]
    done("sweep", "cylinder-step", *words, "--set", "approach=0.3 s", "--out", folder / "sweep")
    return folder / "sweep" / "sweep.html"


def broken(folder):
    words = ["--only", "emergency_stop", "--only", "small_leak"]
    done("faults", "run", "cylinder", *words, "--out", folder, codes=(0, 1))
    return next(folder.rglob("campaign.html"))


def accepted(folder):
    step = SimpleNamespace(name="stop", does="Press the stop.", expects="It vents.")
    told = {"measured_in_words": ["vented in 0.2 s"], "said": "heard", "passed": False}
    facts = {key: "as it was" for _, key in acceptance._FACTS}
    record = {**facts, "rig": "cylinder", "steps": {"stop": told}}
    (folder / acceptance.FOLDER).mkdir(parents=True)
    return acceptance.write_page(folder, record, [step])


@pytest.mark.parametrize("name", RUNS)
def test_reports_have_nothing_that_axe_finds(runs, name):
    with looked_at(runs[name].as_uri()) as pages:
        for page in pages:
            assert troubles(page) == []


@pytest.mark.parametrize("made", [calibrated, swept, broken, accepted])
def test_other_pages_have_nothing_that_axe_finds(made, tmp_path):
    with looked_at(made(tmp_path).as_uri()) as pages:
        for page in pages:
            assert troubles(page) == []


@pytest.mark.parametrize("name", ["cylinder", "joint", "legs"])
def test_a_run_that_is_watched_again_has_nothing_that_axe_finds(runs, name):
    with served_folder(runs[name].parent) as address, looked_at(address) as pages:
        for page in pages:
            shown(page)
            assert troubles(page) == []


def test_a_run_that_is_watched_and_steered_has_nothing_that_axe_finds(tmp_path):
    run = ("cylinder-sine", "--on", "sim", "--pace", "0.2")
    with watched_run(tmp_path, *run) as watched, looked_at(watched.steer) as pages:
        for page in pages:
            shown(page)
            assert page.locator("#gains input").count() > 0
            assert troubles(page) == []


def shown(page):
    end = time.monotonic() + 20.0
    while not page.evaluate("board.columns.length > 0 && board.rows.table.count > 0"):
        assert time.monotonic() < end
        time.sleep(0.05)


def test_what_is_wrong_with_a_page_is_seen(tmp_path):
    path = tmp_path / "wrong.html"
    path.write_text("<title>x</title><div style='width: 2000px'><input><h1>x</h1><h3>y</h3></div>")
    with looked_at(path.as_uri()) as pages:
        told = "\n".join(troubles(next(pages)))
    for word in ("html-has-lang", "label", "heading-order", "pixels are beyond", "critical"):
        assert word in told
