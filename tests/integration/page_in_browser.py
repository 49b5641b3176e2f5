"""A page in a real browser that troubles nobody and is troubled by nothing."""

import shutil
import time
from contextlib import contextmanager

import pytest

CHROMIUM = shutil.which("chromium")
if CHROMIUM is None:
    pytest.skip("there is no chromium: apt-get install chromium", allow_module_level=True)
sync_api = pytest.importorskip("playwright.sync_api", reason="pip install playwright")


def until(page, expression, timeout=20.0):
    """Wait until something is so: `wait_for_function` needs what the page's policy forbids."""
    end = time.monotonic() + timeout
    while not page.evaluate(expression):
        assert time.monotonic() < end, expression
        time.sleep(0.05)


@contextmanager
def browser():
    with sync_api.sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        try:
            yield opened
        finally:
            opened.close()


@contextmanager
def page_of(opened, address, **options):
    context = opened.new_context(viewport={"width": 1600, "height": 900}, **options)
    page = context.new_page()
    page.troubles = []
    page.on("pageerror", lambda error: page.troubles.append(str(error)))
    page.on("console", lambda said: page.troubles.append(said.text))
    page.goto(address)
    until(page, "board.columns.length > 0 && board.rows.table.count > 0")
    yield page
    assert page.troubles == []
    context.close()
