"""The page in a real browser where it may not fail: steering, old data, the stop, hostile names."""

import json
import re
import time

import pytest
from hardware_like import hardware_like
from page_in_browser import browser, page_of, sync_api
from watched import served_folder, watched_run

from rig.run_folder import RunFolder, RunStatus

pytestmark = pytest.mark.slow


def press(page, button):
    box = page.locator(button).bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()


def ask_for(page, value):
    """Set a gain of which it is asked again, say yes: it waits for somebody who holds on."""
    gain = page.locator('#gains input[name="position_rate"]')
    gain.fill(str(value))
    gain.locator("xpath=..").get_by_text("set").click()
    said = page.locator("#gain-said")
    sync_api.expect(said).to_have_text(re.compile("hold to steer"))
    press(page, "#hold")
    sure = said.get_by_role("button", name="yes")
    sync_api.expect(sure).to_be_visible(timeout=20_000)
    page.mouse.up()
    sure.click()
    sync_api.expect(said).to_have_text(re.compile("hold to steer"))


def test_on_hardware_a_gain_changes_while_somebody_holds_on_and_no_longer(tmp_path):
    with (
        browser() as opened,
        hardware_like(tmp_path) as run,
        served_folder(run.folder.path, "--steer") as address,
    ):
        with page_of(opened, address) as page:
            assert page.locator("#kind").inner_text() == "HARDWARE"
            page.locator("#ramp").select_option("0.2")
            ask_for(page, 200)
            time.sleep(1.0)
            assert run.gains.changed == {}  # nobody holds on
            press(page, "#hold")
            sync_api.expect(page.locator("#gain-said")).to_have_text(re.compile("114.7 -> 200"))
            time.sleep(1.0)
            assert run.gains.changed == {"position_rate": 200.0}
            page.mouse.up()

            # A page that is closed in the midst of a ramp has no say any more.
            page.locator("#ramp").select_option("5")
            ask_for(page, 20)
            press(page, "#hold")
            sync_api.expect(page.locator("#gain-said")).to_have_text(re.compile("200 -> 20"))
        time.sleep(1.5)
        left = run.gains.changed["position_rate"]
        assert 100.0 < left < 200.0
        time.sleep(1.0)
        assert run.gains.changed["position_rate"] == left
        said = [event["message"] for event in run.folder.events()][-1]
        assert said == f"position_rate stays at {left:.6g}: nobody holds on to the page"


def test_old_data_are_marked_as_such(tmp_path):
    with (
        browser() as opened,
        hardware_like(tmp_path) as run,
        served_folder(run.folder.path) as address,
        page_of(opened, address) as page,
    ):
        age = page.locator("#age")
        assert age.get_attribute("class") != "old"
        run.pause.set()
        sync_api.expect(age).to_have_class("old", timeout=5_000)
        assert float(age.inner_text().split()[0]) > 1.0
        run.pause.clear()
        sync_api.expect(age).not_to_have_class("old", timeout=5_000)


def test_stop_works_while_everything_else_on_the_page_does_not(tmp_path):
    """Without its program, without a token: the form alone, and it lies over all."""
    with (
        browser() as opened,
        watched_run(tmp_path, "cylinder-sine", "--on", "sim", steer=False) as run,
    ):
        for width, height in ((1600, 900), (390, 844)):
            context = opened.new_context(
                viewport={"width": width, "height": height}, java_script_enabled=False
            )
            page = context.new_page()
            page.goto(run.look.partition("#")[0])
            box = page.locator("#orderly").bounding_box()
            assert box["x"] >= 0 and box["x"] + box["width"] <= width
            assert box["y"] >= 0 and box["y"] + box["height"] <= 200
        page.locator("#at-once").click()
        assert run.process.wait(20) == 130
        context.close()
    assert "at once" in str(RunFolder.open(run.folder).manifest["message"])


def test_names_that_want_to_be_more_than_names_stay_text(tmp_path):
    """Of a folder that somebody sent: its events, its manifest, its profile."""
    folder = RunFolder.create(tmp_path, "page", "hardware", inputs={"profile.yaml": "mechanism: ["})
    evil = "<img src=x onerror=\"window.broken='yes'\"><script>window.broken=1</script>"
    folder.record_event(0.5, evil, evil, data=evil)
    from rig.hal import Column
    from rig.runtime.recorder import LogRecorder

    columns = [Column("reading.x", evil, evil), Column("reading.y", "m", evil)]
    with LogRecorder(folder.log_path, columns) as recorder:
        for k in range(500):
            recorder.write(k, k * 1e-2, (1.0 * k, -1.0 * k))
    folder.manifest["experiment"] = folder.manifest["rig"] = folder.manifest["law"] = evil
    folder.finish(RunStatus.OK, 0, evil)
    with (
        browser() as opened,
        served_folder(folder.path) as address,
        page_of(opened, address) as page,
    ):
        page.locator(".pane .tools button").first.click()
        time.sleep(0.5)
        for width, height in ((1600, 900), (390, 844)):  # however long they are, and before all
            page.set_viewport_size({"width": width, "height": height})
            box = page.locator("#orderly").bounding_box()
            assert box["x"] >= 0 and box["x"] + box["width"] <= width
            on_top = page.evaluate(
                "([x, y]) => document.elementFromPoint(x, y).id",
                [box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]],
            )
            assert on_top == "orderly"
        assert page.evaluate("window.broken") is None
        assert page.locator("img").count() == 0
        assert page.locator("#title").inner_text() == evil
        assert page.locator("#kind").inner_text() == "HARDWARE"
        assert evil in page.locator("#events").inner_text()
        assert page.locator(".pane").count() >= 1
        # Nor does the page load or send anything that is not its own.
        refused = page.evaluate("fetch('http://127.0.0.1:1/').then(() => 'sent', () => 'refused')")
        assert refused == "refused"
        page.troubles = [said for said in page.troubles if "127.0.0.1:1" not in said]
    assert json.loads((folder.path / "manifest.json").read_text())["experiment"] == evil
