"""Pictures of the page of `rig watch` for every rig, and ten seconds of it moving.

    python .readme/pages.py [FOLDER OF RUNS [EXPERIMENT...]]

Runs each experiment (or those that are named) that the folder has no run of, serves its page, and
takes it from a browser; ``watch.webp`` moves.
"""

import io
import re
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
SHOWN = {
    "cylinder-sine": (32.0, ("dark",)),
    "joint-circle-camera": (21.0, ("dark", "phone")),
    "arm-elbow-circle": (7.0, ("light",)),
    "legs-walk": (19.0, ("light",)),
}
"""Experiments, the moment that is shown, s, and how it looks."""
LOOKS = {"light": (1600, 900), "dark": (1600, 900), "phone": (390, 844)}
MOVING, BEGIN, SECONDS, RATE = "joint-circle-camera", 12.0, 10.0, 8
SMALL = (800, 450)
MOST = 500 * 1024
"""Of what moves, bytes: a README is read over slow lines, too."""


@contextmanager
def page_of(run: Path):
    """Yield the address of a run's page."""
    command = [sys.executable, "-m", "rig", "watch", str(run), "--port", "0"]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        yield re.search(r"http://\S+", server.stderr.readline())[0]
    finally:
        server.terminate()
        server.wait()
        server.stderr.close()


def run_of(experiment: str, runs: Path) -> Path:
    """Return the last run of an experiment in a folder, made now if there is none."""
    if not list(runs.glob(f"*-{experiment}-*")):
        command = [sys.executable, "-m", "rig", "run", experiment, "--no-report"]
        subprocess.run([*command, "--out", str(runs)], check=True)
    return max(runs.glob(f"*-{experiment}-*"))


def opened(browser, address: str, look: str):
    """Return a page that shows its run."""
    width, height = LOOKS[look]
    scheme = "dark" if look == "dark" else "light"
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
    page = context.new_page()
    page.goto(address)
    while not page.evaluate("board.rows.fixed.count > 0"):
        time.sleep(0.1)
    return page


def main() -> None:
    """Take all pictures."""
    runs = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())
    named = sys.argv[2:] or list(SHOWN)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox", "--disable-gpu"]
        )
        for experiment in named:
            moment, looks = SHOWN[experiment]
            with page_of(run_of(experiment, runs)) as address:
                for look in looks:
                    page = opened(browser, address, look)
                    page.evaluate(f"board.moment.jump({moment})")
                    while not page.evaluate(f"board.scene.holds({moment})"):
                        time.sleep(0.1)
                    time.sleep(2.0)
                    shot = Image.open(io.BytesIO(page.screenshot()))
                    name = f"watch-{experiment.partition('-')[0]}-{look}.webp"
                    shot.save(HERE / name, quality=88, method=6)
                    page.context.close()
                if experiment == MOVING:
                    move(opened(browser, address, "dark"))
        browser.close()


def move(page) -> None:
    """Take the page while its run is played."""
    frames = []
    page.evaluate(f"board.moment.hold({BEGIN - 2}, {BEGIN + SECONDS + 1})")
    for number in range(round(SECONDS * RATE)):
        page.evaluate(f"board.moment.head = {BEGIN + number / RATE}")
        time.sleep(1.0 if not number else 0.12)
        shot = Image.open(io.BytesIO(page.screenshot()))
        frames.append(shot.convert("RGB").resize(SMALL, Image.Resampling.LANCZOS))
    for quality in range(55, 0, -10):
        moving = io.BytesIO()
        frames[0].save(
            moving, "WEBP", save_all=True, append_images=frames[1:], duration=1000 // RATE,
            loop=0, quality=quality, method=4,
        )  # fmt: skip
        if len(moving.getvalue()) <= MOST:
            break
    (HERE / "watch.webp").write_bytes(moving.getvalue())


if __name__ == "__main__":
    main()
