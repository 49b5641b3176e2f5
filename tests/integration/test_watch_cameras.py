"""The camera's picture on the page: the frame that was searched, through the gate, and no more."""

import asyncio
import struct
import time

import numpy as np
import pytest
from watched import LOCAL, paced_run, watched_run

from rig.run_folder import RunFolder
from rig.runtime.log import read_log
from rig.watching.messages import CAMERA

aiohttp = pytest.importorskip("aiohttp", reason="pip install -e '.[watch]'")
cv2 = pytest.importorskip("cv2")
pytestmark = pytest.mark.slow

EXPERIMENT = ("joint-circle-camera", "--on", "virtual", "--seed", "3")
WAIT = 60.0
SECONDS = 3.0


async def look_on(run, pictures):
    """Show the token, and return when so many pictures have come: (when, the message) of each."""
    here, heard, found = f"http://{LOCAL}:{run.port}", 0, []
    async with aiohttp.ClientSession() as session:
        page = await session.ws_connect(f"{here}/ws", origin=here, max_msg_size=0)
        await page.send_json({"type": "open", "token": run.token})
        while len(found) < pictures:
            message = await page.receive(WAIT)
            heard += 1
            assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY)
            if message.type is aiohttp.WSMsgType.BINARY:
                if struct.unpack_from("<I", message.data)[0] == CAMERA:
                    found.append((time.monotonic(), message.data))
            elif message.json()["type"] == "status":
                await page.send_json({"type": "here", "heard": heard})
        await page.close()
    return found


async def peep(run):
    """See no picture without the token."""
    here = f"http://{LOCAL}:{run.port}"
    async with aiohttp.ClientSession() as session:
        page = await session.ws_connect(f"{here}/ws", origin=here, max_msg_size=0)
        await page.send_json({"type": "open", "token": run.token[::-1]})
        assert (await page.receive(WAIT)).type is aiohttp.WSMsgType.CLOSE
        for path in ("/camera.picture", "/page/camera.picture", "/camera", "/pictures/0"):
            assert (await session.get(here + path)).status == 404


def read(message):
    """Return marks (n, 2), the width of the image, the verdict, and the picture's pixels."""
    kind, _, count, width, _ = struct.unpack_from("<IIIId", message)
    assert (kind, width) == (CAMERA, 1)
    marks = np.frombuffer(message, "<f4", 2 * count, 24).reshape(-1, 2)
    across, _, word = struct.unpack_from("<HH24s", message, 24 + 8 * count)
    jpeg = message[24 + 8 * count + 28 :]
    pixels = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_UNCHANGED)
    return marks, across, word.rstrip(b"\0").decode(), pixels


def test_the_page_is_shown_what_the_camera_saw_and_the_run_is_none_the_worse(tmp_path):
    with watched_run(tmp_path / "watched", *EXPERIMENT, steer=False) as run:
        found = asyncio.run(asyncio.wait_for(look_on(run, 30), 120.0))
        asyncio.run(asyncio.wait_for(peep(run), 60.0))
        assert (run.folder / "camera.picture").stat().st_mode & 0o077 == 0
        while read_log(run.folder / "log.mcap").t[-1] < SECONDS:
            time.sleep(0.2)
    spans = np.diff([at for at, _ in found])
    assert np.median(spans) > 0.08  # ten a second at most
    assert max(len(message) for _, message in found) < 60_000
    places = []
    for _, message in found:
        marks, width, word, pixels = read(message)
        assert word == "seen"
        rows, columns = np.nonzero(pixels > 150)  # the disc, without any detector
        scale = width / pixels.shape[1]
        centre = np.array([columns.mean(), rows.mean()])
        assert np.abs((centre + 0.5) * scale - 0.5 - marks[0]).max() < 1.5
        places.append(marks[0])
    assert len({tuple(place) for place in places}) > 10  # it moves, and so do the pictures
    assert not list(run.folder.glob("*.picture"))

    # Nobody looks at the second one: nothing is written for eyes, and it is the same to the bit.
    with paced_run(tmp_path / "alone", *EXPERIMENT) as folder:
        until = time.monotonic() + 120.0
        while not (log := folder / "log.mcap").exists() or read_log(log).t[-1] < SECONDS:
            assert time.monotonic() < until
            time.sleep(0.2)
        (picture,) = folder.glob("*.picture")
        assert picture.stat().st_size < 100
    one, other = (read_log(RunFolder.open(path).log_path) for path in (run.folder, folder))
    count = int(np.searchsorted(one.t, SECONDS))
    for column in one.columns:
        if not column.name.startswith("timing."):
            name = column.name
            assert np.array_equal(
                one.column(name)[:count], other.column(name)[:count], equal_nan=True
            ), name
