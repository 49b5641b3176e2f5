"""The page in a real browser: what it shows is the log, and what it asks for happens."""

import re
import subprocess
import sys
import time

import numpy as np
import pytest
from page_in_browser import browser, page_of, sync_api, until
from watched import served_folder, watched_run

from rig.run_folder import RunFolder, RunStatus
from rig.runtime.log import read_log

pytestmark = pytest.mark.slow

PLOTTED = "reading.position"


def at_cursor(page):
    """Hover over the middle of the first pane; return the time and the value that it tells."""
    box = page.locator(".pane canvas").first.bounding_box()
    page.mouse.move(box["x"] + 0.55 * box["width"], box["y"] + 0.5 * box["height"])
    time.sleep(0.3)
    value = page.locator(f'.pane [data-column="{PLOTTED}"] b').first
    return float(value.get_attribute("data-t")), float(value.get_attribute("data-value"))


def logged_at(folder, t, column=PLOTTED):
    log = read_log(folder / "log.mcap")
    row = int(np.argmin(np.abs(log.t - t)))
    assert abs(log.t[row] - t) < 2e-5  # times are told in single precision from the first one
    return log.column(column)[row]


def agree(page, told):
    """Say yes if a change is asked again, and wait until it is the loop's."""
    sure = page.locator("#gain-said button")
    said = page.locator("#gain-said").filter(has_text=told)
    sync_api.expect(sure.or_(said)).to_be_visible(timeout=20_000)
    if sure.count():
        sure.click()
    sync_api.expect(said).to_be_visible(timeout=20_000)
    begun = page.evaluate("board.events.all.findLast((event) => event.kind === 'tuning').t")
    ramp = float(told.split()[1])
    until(page, f"board.status.t > {begun + ramp + 0.2}", 40)


def pixels(page):
    """Return what the scene's canvas shows."""
    return page.evaluate("document.getElementById('scene').toDataURL()")


def test_a_run_is_watched_steered_and_stopped_in_a_browser(tmp_path):
    with (
        browser() as opened,
        watched_run(tmp_path, "cylinder-sine", "--on", "sim", "--pace", "0.5") as run,
        page_of(opened, run.steer) as page,
    ):
        assert page.locator("#kind").inner_text() == "SIMULATED"
        assert "cylinder-sine" in page.title()
        first = pixels(page)
        until(page, f"document.getElementById('scene').toDataURL() !== '{first}'", 20)  # it moves
        assert page.locator("#age").inner_text() < "1.0 s old"

        # A channel in a pane, and its value at a cursor, are those of the log.
        page.locator("#play").click()  # hold still
        page.evaluate("board.moment.hold(board.moment.head - 1, board.moment.head)")
        time.sleep(0.8)
        t, live = at_cursor(page)
        assert live == pytest.approx(logged_at(run.folder, t), rel=1e-6)
        page.locator("#live").click()

        # A gain: one is refused by the page's server, one is changed, and the log says so.
        gain = page.locator('#gains input[name="position_rate"]')
        row = gain.locator("xpath=..")
        gain.fill("100000")
        row.get_by_text("set").click()
        until(page, "document.getElementById('gain-said').textContent.includes('has to')")
        gain.fill("90")
        row.get_by_text("set").click()
        agree(page, "within 1 s")

        # It is undone within the time that is chosen, and there is nothing more to be undone.
        page.locator("#ramp").select_option("0.2")
        row.get_by_text("undo").click()
        agree(page, "within 0.2 s")
        assert row.get_by_text("undo").is_disabled()
        gain.fill("80")
        row.get_by_text("set").click()
        agree(page, "within 0.2 s")

        # A link that is given away permits to look, also if it comes from a page that steers.
        assert page.evaluate("board.described.look") == run.look.partition("#")[2]
        assert page.evaluate("board.token") == run.steer.partition("#")[2]

        page.get_by_role("button", name="STOP").click()
        assert run.process.wait(40) == 130
        until(page, "board.status && !board.status.live")
        assert "asked to stop" in page.frame(name="stopped").content()

    folder = RunFolder.open(run.folder)
    assert folder.status is RunStatus.ABORTED
    assert "stopped by the operator" in str(folder.manifest["message"])
    log = read_log(folder.log_path)
    assert log.complete
    changes = [event for event in folder.events() if event["kind"] == "tuning"]
    change, undone, last = changes
    assert [undone["data"]["new"], undone["data"]["old"]] == [change["data"]["old"], 90.0]
    assert undone["t"] > change["t"] + 0.99  # the ramp is over
    # By the log's clock, whose seconds before the motion are not negative.
    assert log.column("reference.time")[0] < -0.5
    assert all(0.0 < event["t"] < log.t[-1] for event in changes)
    assert change["data"]["key"] == "position_rate"
    assert change["data"]["new"] == 90.0
    assert change["data"]["who"]
    assert last["data"]["new"] == 80.0
    assert "position_rate: 80.0" in (folder.path / "gains.yaml").read_text()

    # Played again, it says what was seen live.
    with (
        browser() as opened,
        served_folder(run.folder) as address,
        page_of(opened, address) as page,
    ):
        page.evaluate(f"board.moment.hold({t} - 0.55, {t} + 0.45); board.cursor = {t}")
        time.sleep(0.8)
        page.evaluate(f"board.cursor = {t}")
        time.sleep(0.3)
        told = page.locator(f'.pane [data-column="{PLOTTED}"] b').first
        assert float(told.get_attribute("data-value")) == live
        before = pixels(page)
        page.evaluate("board.moment.head = 3.0")
        time.sleep(0.5)
        assert pixels(page) != before
        page.locator("#earlier").click()
        page.locator("#later").click()
        assert page.evaluate("board.events.all.some((event) => event.t === board.moment.head)")


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory):
    """Two short runs of one experiment, with other seeds."""
    out = tmp_path_factory.mktemp("two")
    runs = []
    for seed in (1, 2):
        command = [sys.executable, "-m", "rig", "run", "cylinder-step", "--on", "sim"]
        subprocess.run(
            [*command, "--seed", str(seed), "--no-report", "--out", str(out / str(seed))],
            capture_output=True, timeout=120, check=True,
        )  # fmt: skip
        runs += (out / str(seed)).iterdir()
    return runs


def test_a_link_leads_to_a_moment_and_what_is_shown_can_be_saved(two_runs, tmp_path):
    one, other = two_runs
    log, beside = read_log(one / "log.mcap"), read_log(other / "log.mcap")
    t = float(log.t[len(log.t) // 2])
    with (
        browser() as opened,
        served_folder(one, "--beside", str(other)) as address,
        page_of(opened, f"{address}&t={t:.4f}&w=0.5") as page,
    ):
        span = "(board.moment.window[1] - board.moment.window[0])"
        until(page, f"board.moment.still && Math.abs({span} - 0.5) < 1e-6")
        until(page, "board.rows.fixed.count > 100 && board.rows.other.count > 100")
        assert page.evaluate("board.moment.head") == pytest.approx(t, abs=1e-4)
        with page.expect_download() as saving:
            page.get_by_role("button", name="csv").first.click()
        saving.value.save_as(tmp_path / "shown.csv")
        saved = np.genfromtxt(tmp_path / "shown.csv", delimiter=",", names=True, deletechars="")
        shown = (log.t >= t - 0.25) & (log.t < t + 0.25)
        assert abs(len(saved) - shown.sum()) <= 2
        names = saved.dtype.names
        column = next(k for k, name in enumerate(names) if PLOTTED in name)
        for row in saved[:: len(saved) // 20]:
            assert row[column] == pytest.approx(logged_at(one, row[0]), rel=1e-6)

        # Each button says what came of it; without leave nothing is copied.
        link = page.locator("#link")
        link.click()
        sync_api.expect(link).to_have_text(re.compile("^(not )?copied$"))
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        sync_api.expect(link).to_have_text("link")
        link.click()
        sync_api.expect(link).to_have_text("copied")
        copied = page.evaluate("navigator.clipboard.readText()")
        assert copied.startswith(f"{address}&t={t:.4f}&w=0.5")
        page.locator("#save").click()
        sync_api.expect(page.locator("#save")).to_have_text("layout kept")
        sync_api.expect(page.locator("#save")).to_have_text("save layout")

        # The other run is what it is, and not the first one once more.
        place = page.evaluate(
            f"board.rows.other.columns.findIndex((k) => board.columns[k][0] === '{PLOTTED}')"
        )
        got = page.evaluate(
            f"[board.rows.other.t, board.rows.other.values[{place}]]"
            ".map((all) => Array.from(all.subarray(0, board.rows.other.count)))"
        )
        rows = np.searchsorted(beside.t, np.array(got[0]) - 5e-5)
        wanted = beside.column(PLOTTED)[rows]
        assert np.allclose(got[1], wanted, rtol=1e-6, atol=1e-12)
        assert not np.allclose(got[1], log.column(PLOTTED)[rows], rtol=1e-6, atol=1e-12)

        # Zoomed and moved by a hand; the panes that are kept come back with the next page.
        box = page.locator(".pane canvas").first.bounding_box()
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        page.mouse.wheel(0, -400)
        until(page, "board.moment.still[1] - board.moment.still[0] < 0.4")
        # A favourite is found first, also by the next page.
        page.locator(".pane .tools button").first.click()
        last = page.locator("#found input").last.get_attribute("name")
        page.locator("#found .star").last.click()
        assert page.locator("#found input").first.get_attribute("name") == last
        page.reload()
        until(page, "board.panes.length > 0")
        page.locator(".pane .tools button").first.click()
        assert page.locator("#found input").first.get_attribute("name") == last
        page.locator("#picker").get_by_role("button", name="done").click()

        count = page.locator(".pane").count()
        page.locator(".pane .tools button", has_text="×").last.click()
        page.get_by_role("button", name="save layout").click()
        page.reload()
        until(page, "board.panes.length > 0")
        assert page.locator(".pane").count() == count - 1
        page.get_by_role("button", name="reset").click()
        assert page.locator(".pane").count() == count


WAYS = {
    "↕": lambda a, b: (a < 4e-3) != (b < 4e-3),
    "↑": lambda a, b: (a < 4e-3) & (b >= 4e-3),
    "↓": lambda a, b: (a >= 4e-3) & (b < 4e-3),
    ">": lambda a, b: b > 4e-3,
    "<": lambda a, b: b < 4e-3,
}


def test_each_kind_of_trigger_holds_the_page_still(tmp_path):
    with (
        browser() as opened,
        watched_run(tmp_path, "cylinder-sine", "--on", "sim", steer=False) as run,
        page_of(opened, run.look) as page,
    ):
        assert page.evaluate("board.moment.isLive")
        heads = {}
        tool = page.locator(".pane").first.get_by_role("button", name=re.compile("^hold"))
        for number, way in enumerate(WAYS, start=1):
            page.evaluate(
                "board.moment.hold(board.moment.head - 1, board.moment.head)"
            )  # else the first way holds it
            for _ in range(number):
                tool.click()
            assert tool.inner_text() == f"hold {way}"
            page.evaluate("board.panes[0].trigger.level = 4.0")  # mm; the sine goes to 9
            page.locator("#live").click()
            until(page, "board.moment.isLive || !board.panes[0].trigger")
            until(page, "!board.moment.isLive", 40)
            heads[way] = page.evaluate("board.moment.head")
            assert page.evaluate("board.moment.window[1] - board.moment.window[0]") >= 10.0
            assert tool.inner_text() == "hold"
    log = read_log(run.folder / "log.mcap")
    position = log.column(PLOTTED)
    for way, fires in WAYS.items():
        fired = log.t[1:][fires(position[:-1], position[1:])]
        assert np.abs(fired - heads[way]).min() < 5e-3


def test_the_choice_of_windows_says_how_wide_the_window_is(tmp_path):
    with (
        browser() as opened,
        watched_run(tmp_path, "cylinder-sine", "--on", "sim", steer=False) as run,
        page_of(opened, run.look) as page,
    ):
        shown = "document.getElementById('window').selectedOptions[0].textContent"
        assert page.evaluate(shown) == "10 s"  # live
        until(page, "board.status.t > 8", 60)  # that two and three seconds are not all of it
        for asked, said in (("2, 4", "2 s"), ("1, 4.14", "3.1 s"), ("0, board.status.t", "all")):
            page.evaluate(f"board.moment.hold({asked})")
            assert page.evaluate(shown) == said
        page.evaluate("board.moment.jump(5)")
        page.locator("#window").select_option("2")
        assert page.evaluate("board.moment.window[1] - board.moment.window[0]") == pytest.approx(
            2.0
        )
        page.evaluate("board.moment.zoom(1.5, board.moment.head)")
        assert page.evaluate(shown) == "3 s"
        page.locator("#live").click()
        assert page.evaluate(shown) == "10 s"
