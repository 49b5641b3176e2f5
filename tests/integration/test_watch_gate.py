"""Who may look at a run and who may not, by real requests; and that the run notices none of it."""

import asyncio
import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest
from watched import LOCAL, served_folder, server_of, watched_run

from rig.replaying.difference import first_difference
from rig.run_folder import RunFolder, RunStatus

aiohttp = pytest.importorskip("aiohttp", reason="pip install -e '.[watch]'")

WAIT = 30.0
DEAF = 10
"""Pages that do not read."""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("watched")
    with watched_run(out, "cylinder-sine", "--on", "sim", "--pace", "0.3") as going:
        yield going
        assert going.process.poll() is None  # whatever the tests did, the run goes on
        manifest = json.loads((going.folder / "manifest.json").read_text())
        assert manifest["status"] == "running"


def origin(run):
    return f"http://{LOCAL}:{run.port}"


def raw(run, request: str, *, ends: str = "\n") -> bytes:
    """Send bytes as they are; return what comes back until the other end has had enough."""
    with socket.create_connection((LOCAL, run.port), timeout=WAIT) as connection:
        connection.sendall((request.replace(ends, "\r\n") if ends else request).encode())
        connection.settimeout(2.0)
        answer = b""
        try:
            while piece := connection.recv(65536):
                answer += piece
                if b"\r\n\r\n" in answer:
                    break
        except TimeoutError:
            pass
        return answer


UPGRADE = (
    "Upgrade: websocket\nConnection: Upgrade\nSec-WebSocket-Version: 13\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\n"
)


@pytest.mark.parametrize(
    ("host", "extra", "status"),
    [
        ("rig.example.com:{port}", "Origin: http://rig.example.com:{port}\n", 421),  # rebinding
        ("127.0.0.1.example.com:{port}", "Origin: http://127.0.0.1:{port}\n", 421),
        ("127.0.0.1", "Origin: http://127.0.0.1\n", 421),
        ("127.0.0.1:{port}", "Origin: http://example.com\n", 403),  # a page of another site
        ("127.0.0.1:{port}", "Origin: http://localhost:1\n", 403),
        ("127.0.0.1:{port}", "Origin: null\n", 403),
        ("127.0.0.1:{port}", "Origin: https://127.0.0.1:{port}\n", 403),
        ("127.0.0.1:{port}", "Origin: http://localhost:{port}\n", 403),
        ("127.0.0.1:{port}", "", 403),  # a program that says nothing
    ],
)
@pytest.mark.parametrize("what", ["socket", "stop"])
def test_only_the_page_itself_opens_the_socket_and_stops(run, what, host, extra, status):
    place = {"host": host.format(port=run.port), "extra": extra.format(port=run.port)}
    if what == "socket":
        request = f"GET /ws HTTP/1.1\nHost: {place['host']}\n{place['extra']}{UPGRADE}\n"
    else:
        body = "how=orderly"
        request = (
            f"POST /stop HTTP/1.1\nHost: {place['host']}\n{place['extra']}"
            f"Content-Type: application/x-www-form-urlencoded\nContent-Length: {len(body)}\n\n"
            f"{body}"
        )
    assert raw(run, request).startswith(f"HTTP/1.1 {status} ".encode())


@pytest.mark.parametrize(
    ("headers", "body"),
    [
        ("Content-Type: application/x-www-form-urlencoded", "how=x"),
        ("Content-Type: application/x-www-form-urlencoded", "how=\ufffd"),
        ("Content-Type: application/x-www-form-urlencoded; charset=no-such", "how=orderly"),
        ("Content-Type: application/json", '{"how": "orderly"}'),
        ("Content-Type: multipart/form-data", "how=orderly"),
        (
            "Content-Type: multipart/form-data; boundary=x",
            '--x\nContent-Disposition: form-data; name="how"; filename="x"\n\norderly\n--x--\n',
        ),
        (
            "Content-Type: multipart/form-data; boundary=x",
            "--x\nContent-Encoding: no\n\nx\n--x--\n",
        ),
    ],
)
def test_what_is_no_form_of_ours_stops_nothing(run, headers, body):
    body = body.replace("\n", "\r\n")
    request = (
        f"POST /stop HTTP/1.1\nHost: {LOCAL}:{run.port}\nOrigin: {origin(run)}\n"
        f"{headers}\nContent-Length: {len(body.encode())}\n\n"
    )
    assert raw(run, request.replace("\n", "\r\n") + body, ends="").startswith(b"HTTP/1.1 400 ")


def test_nothing_but_loopback_listens(run):
    own = {
        line.split()[1]
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[3] == "0A"
    }
    wanted = f"{struct.unpack('<I', socket.inet_aton(LOCAL))[0]:08X}:{run.port:04X}"
    assert wanted in own
    assert f"00000000:{run.port:04X}" not in own


def test_a_page_may_load_and_frame_nothing_but_its_own(run):
    answer = raw(run, f"GET / HTTP/1.1\nHost: {LOCAL}:{run.port}\n\n").decode()
    policy = re.search(r"Content-Security-Policy: (.*)\r", answer)[1]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy and "http:" not in policy and "*" not in policy
    for path in (
        "/page/../server.py",
        "/page/%2e%2e/server.py",
        "/page/index.py",
        "/manifest.json",
    ):
        got = raw(run, f"GET {path} HTTP/1.1\nHost: {LOCAL}:{run.port}\n\n")
        assert got.startswith(b"HTTP/1.1 404 ")
    assert run.token not in answer


async def opened(session, run, token):
    """Open the socket and show a token; return it and the first message."""
    page = await session.ws_connect(f"{origin(run)}/ws", origin=origin(run), max_msg_size=0)
    await page.send_json({"type": "open", "token": token})
    return page, await page.receive(WAIT)


def asked(coroutine):
    return asyncio.run(asyncio.wait_for(coroutine, 90.0))


@pytest.mark.parametrize("seed", range(5))
def test_a_wrong_token_sees_nothing(run, seed):
    chance = random.Random(seed)
    steering = run.steer.partition("#")[2]
    wrong = [
        "", run.token[:-1], run.token + "A", run.token.swapcase(), "\ud800", "x" * 60,
        "".join(chance.choices("abcXYZ019-_", k=22)),
    ]  # fmt: skip
    assert len(run.token) >= 22 and run.token != steering

    async def work():
        async with aiohttp.ClientSession() as session:
            for token in wrong:
                page, first = await opened(session, run, token)
                assert first.type is aiohttp.WSMsgType.CLOSE
                assert first.data == 4401
                await page.close()
            page, first = await opened(session, run, run.token)
            assert first.json()["type"] == "hello"
            assert first.json()["steers"] is False
            await page.send_json(
                {"type": "gain", "key": "position_rate", "value": 50.0, "ramp": 1.0, "sure": True}
            )
            while True:
                message = await page.receive(WAIT)
                if message.type is aiohttp.WSMsgType.TEXT and message.json()["type"] == "refused":
                    assert "may look" in message.json()["message"]
                    break
            await page.close()

    asked(work())
    events = (run.folder / "events.jsonl").read_text()
    assert "tuning" not in events


def malformed(chance):
    """Return a message that no page sends."""
    types = ["open", "here", "follow", "view", "frames", "gain", "hold", "stop", "", "__proto__"]
    values = [
        None, True, -1, 1e308, float("nan"), 2**70, "", "x" * 5000, [], [[]], {}, {"a": 1},
        [0] * 3000, [-1], ["0"], "<script>", [1e9], [99999],
    ]  # fmt: skip
    names = ["id", "columns", "seconds", "from", "to", "most", "key", "value", "heard", "token"]
    kind = chance.randrange(5)
    if kind == 0:
        return os.urandom(chance.randrange(1, 4000))
    if kind == 1:
        return "[" * chance.randrange(1, 9000)
    if kind == 2:
        return json.dumps(chance.choice(values))
    told = {name: chance.choice(values) for name in chance.sample(names, chance.randrange(6))}
    if kind == 3:
        told["type"] = chance.choice([*types, None, 3, []])
        return json.dumps(told)
    return json.dumps({"type": chance.choice(types), **told})[: chance.randrange(1, 200)]


def test_a_thousand_malformed_messages_change_nothing(run):
    chance = random.Random(21)
    before = (run.folder / "log.mcap").stat().st_size

    async def work():
        sent = 0
        async with aiohttp.ClientSession() as session:
            while sent < 1000:
                page, first = await opened(session, run, run.steer.partition("#")[2])
                assert first.json()["type"] == "hello"
                try:
                    while sent < 1000:
                        message = malformed(chance)
                        sent += 1
                        if isinstance(message, bytes):
                            await page.send_bytes(message)
                        else:
                            await page.send_str(message)
                except (ConnectionError, aiohttp.ClientError):
                    pass  # it has had enough of us
                await page.close()
            page, first = await opened(session, run, run.token)
            assert first.json()["type"] == "hello"
            await page.close()

    asked(work())
    until = time.monotonic() + 30.0  # it may be compiling just now
    while (run.folder / "log.mcap").stat().st_size <= before:
        assert time.monotonic() < until, "the run does not go on"
        time.sleep(0.1)
    assert "tuning" not in (run.folder / "events.jsonl").read_text()


def test_an_answer_has_its_bounds_whatever_is_asked_for(run):
    wish = {"id": 5, "columns": [1, 2] * 128, "from": -1e300, "to": 1e300, "most": 20_000}

    async def work():
        async with aiohttp.ClientSession() as session:
            page, _ = await opened(session, run, run.token)
            heard = 1
            while True:
                message = await page.receive(WAIT)
                heard += 1
                if message.type is aiohttp.WSMsgType.TEXT and message.json()["type"] == "status":
                    await page.send_json({"type": "here", "heard": heard})
                    if message.json()["count"] > 4000:  # more than what is sent
                        await page.send_json({"type": "view", **wish})
                if message.type is aiohttp.WSMsgType.BINARY:
                    kind, number, count, width = struct.unpack_from("<IIII", message.data)
                    if (kind, number) == (1, 5):
                        break
            await page.close()
        assert width == 256
        assert 0 < count * width <= 500_000

    asked(work())


@pytest.mark.parametrize("value", ["1e300", "-1", "NaN", "1e999", '"50"', "true", "null"])
def test_a_gain_beyond_reason_is_refused_also_as_the_first_message(run, value):
    wish = f'{{"type": "gain", "key": "position_rate", "value": {value}, "ramp": 1, "sure": true}}'

    async def work():
        async with aiohttp.ClientSession() as session:
            page, _ = await opened(session, run, run.steer.partition("#")[2])
            await page.send_str(wish)
            while True:
                message = await page.receive(WAIT)
                if message.type is aiohttp.WSMsgType.TEXT:
                    told = message.json()
                    if told["type"] in ("steered", "refused"):
                        break
            await page.close()
        assert re.search("has to be 2 … 250|value is not what it may be|no JSON", told["message"])

    asked(work())
    assert "tuning" not in (run.folder / "events.jsonl").read_text()


def test_fifty_pages_look_on_and_the_next_ones_are_told_when_it_is_too_much(run):
    async def look(session, seconds):
        page, _ = await opened(session, run, run.token)
        rows, heard, until = 0, 1, time.monotonic() + seconds
        await page.send_json({"type": "follow", "id": 1, "columns": [1, 5], "seconds": 5.0})
        while time.monotonic() < until:
            message = await page.receive(WAIT)
            heard += 1
            if message.type is aiohttp.WSMsgType.BINARY:
                kind, number, count = struct.unpack_from("<III", message.data)
                rows += count if (kind, number) == (1, 1) else 0
            elif message.type is not aiohttp.WSMsgType.TEXT:
                break
            elif message.json()["type"] == "status":
                await page.send_json({"type": "here", "heard": heard})
        await page.close()
        return rows

    async def work():
        connector = aiohttp.TCPConnector(limit=0)
        async with aiohttp.ClientSession(connector=connector) as session:
            rows = await asyncio.gather(*(look(session, 6.0) for _ in range(50)))
            assert min(rows) > 1000
            many = await asyncio.gather(
                *(opened(session, run, run.token) for _ in range(80)), return_exceptions=True
            )
            refused = [one for one in many if isinstance(one, aiohttp.WSServerHandshakeError)]
            assert len(refused) >= 16
            assert {one.status for one in refused} == {503}

    asked(work())


def server_memory(run):
    """Return what the server's process has in memory, bytes."""
    text = Path(f"/proc/{server_of(run.folder)}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", text)[1])


def test_who_is_watched_does_the_same(tmp_path):
    """Every number of the log but those of the wall's clock, whoever looks on."""

    async def look(going):
        async with aiohttp.ClientSession() as session:
            page, _ = await opened(session, going, going.token)
            await page.send_json({"type": "follow", "id": 1, "columns": [1], "seconds": 5.0})
            while (await page.receive(WAIT)).type is not aiohttp.WSMsgType.BINARY:
                pass
            await page.close()

    options = ("cylinder-step", "--on", "sim", "--seed", "7", "--no-report")
    with watched_run(tmp_path / "watched", *options[:-1], "--pace", "4") as going:
        asked(look(going))
        assert going.process.wait(60) == 0
    command = [sys.executable, "-m", "rig", "run", *options, "--out", str(tmp_path / "alone")]
    assert subprocess.run(command, capture_output=True, timeout=120, check=False).returncode == 0
    (alone,) = (tmp_path / "alone").iterdir()
    assert first_difference(RunFolder.open(alone), RunFolder.open(going.folder)) is None


@pytest.mark.slow
def test_ten_pages_that_never_read_are_dropped_and_cost_little(run):
    time.sleep(12.0)  # those of the other tests are gone
    before = most = server_memory(run)
    begun = time.monotonic()
    deaf = [deaf_page(run) for _ in range(DEAF)]
    lasted = []
    while deaf and time.monotonic() - begun < 16.0:
        most = max(most, server_memory(run))
        for connection in deaf.copy():
            try:  # we may always write: what comes back is a reset once it has dropped us
                connection.sendall(masked(b'{"type": "here", "heard": 0}'))
            except ConnectionError:
                lasted.append(time.monotonic() - begun)
                deaf.remove(connection)
                connection.close()
        time.sleep(0.45)
    assert deaf == [], "some were never dropped"
    assert max(lasted) < 15.0
    assert most - before < DEAF * 20e6


def deaf_page(run):
    """Return the connection of a page that asks for all there is, and reads nothing of it."""
    connection = socket.create_connection((LOCAL, run.port), timeout=WAIT)
    connection.sendall(
        f"GET /ws HTTP/1.1\r\nHost: {LOCAL}:{run.port}\r\nOrigin: {origin(run)}\r\n"
        f"{UPGRADE}\r\n".replace("\n", "\r\n")
        .replace("\r\r", "\r")
        .encode()
    )
    for message in (
        {"type": "open", "token": run.token},
        {"type": "follow", "id": 1, "columns": list(range(30)) * 8, "seconds": 60.0},
    ):
        connection.sendall(masked(json.dumps(message).encode()))
    return connection


def masked(payload: bytes) -> bytes:
    """Return a text frame as a client sends it (RFC 6455, section 5)."""
    head = b"\x81" + (
        bytes([0x80 | len(payload)]) if len(payload) < 126
        else b"\xfe" + struct.pack(">H", len(payload))
    )  # fmt: skip
    mask = b"\x01\x02\x03\x04"
    return head + mask + bytes(byte ^ mask[k % 4] for k, byte in enumerate(payload))


def test_the_page_of_a_run_that_was_killed_says_so(tmp_path):
    folder = RunFolder.create(tmp_path, "killed", "sim", inputs={"profile.yaml": "no: profile"})
    os.close(folder._events_fd)  # as a killed process lets go of it

    async def work(address):
        port = int(re.search(r":(\d+)/", address)[1])
        here = f"http://{LOCAL}:{port}"
        async with aiohttp.ClientSession() as session:
            page = await session.ws_connect(f"{here}/ws", origin=here)
            await page.send_json({"type": "open", "token": address.partition("#")[2]})
            while True:
                told = (await page.receive(WAIT)).json()
                if told["type"] == "status":
                    break
            assert told["state"] == "crashed"
            assert told["live"] is False
            await page.close()
            answer = await session.post(
                f"{here}/stop", data={"how": "orderly"}, headers={"Origin": here}
            )
            assert "not running" in await answer.text()

    with served_folder(folder.path) as address:
        asked(work(address))


def test_a_server_that_is_told_to_end_does_so_although_a_page_is_open(tmp_path):
    folder = RunFolder.create(tmp_path, "ended", "sim", inputs={"profile.yaml": "no: profile"})
    folder.finish(RunStatus.OK, 0)

    async def look_on(address, server):
        here, _, token = address.partition("/#")
        async with aiohttp.ClientSession() as session:
            page = await session.ws_connect(f"{here}/ws", origin=here)
            await page.send_json({"type": "open", "token": token})
            assert (await page.receive(WAIT)).json()["type"] == "hello"
            os.kill(server, signal.SIGTERM)
            begun = time.monotonic()
            while (await page.receive(WAIT)).type is aiohttp.WSMsgType.TEXT:
                pass
            return time.monotonic() - begun

    with served_folder(folder.path) as address:
        assert asked(look_on(address, server_of(folder.path))) < 5.0
