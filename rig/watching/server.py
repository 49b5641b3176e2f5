"""The one listener: the page's files, its web socket, and the form that stops the run."""

import asyncio
import contextlib
import html
import logging
import os
import signal
import socket as sockets
from collections.abc import Awaitable, Callable
from datetime import datetime
from importlib.resources import files
from pathlib import Path
from time import monotonic

from aiohttp import WSMsgType, web

from rig.hal import RigError
from rig.stopping import request_stop
from rig.watching.followed_run import FollowedRun
from rig.watching.gate import HEADERS, Gate, Tokens, policy
from rig.watching.messages import LONGEST, BadMessage, parse
from rig.watching.steering import Steering
from rig.watching.studio import Studio
from rig.watching.viewer import Viewer

PORT = 8765
_LOOPBACK = "127.0.0.1"
_MOST_VIEWERS = 64
_TO_OPEN = 5.0
"""Within which a page has to show its token, s."""
_TO_LEAVE = 0.5
"""What a page has, whose server was told to end, s: it asks again by itself."""
_KERNEL_BUFFER = 256 << 10
"""Bytes that the system keeps for a page that does not read."""
_LEAVES_AFTER = 60.0
"""Without anybody who looks on, of a run that has ended, s."""
_KINDS = {
    "html": "text/html",
    "css": "text/css",
    "js": "text/javascript",
}
_STOPS = {"orderly": False, "at once": True}

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class WatchServer:
    """Serves the page of one run on loopback.

    Parameters
    ----------
    run : Path
        Its folder.
    beside : Path, optional
        The folder of another run, to be laid under it.
    steer : bool
        Whether gains may be changed, with a token of their own.
    leaves : bool
        End when the run has ended and nobody has looked on for a minute.
    """

    def __init__(
        self, run: Path, beside: Path | None = None, *, steer: bool = False, leaves: bool = False
    ) -> None:
        self._path = run
        self._leaves = leaves
        self._steering = Steering(run) if steer else None
        self._followed = FollowedRun(run)
        self._beside = None if beside is None else FollowedRun(beside)
        self.tokens = Tokens.draw(steer=steer)
        self._gate: Gate
        self._studio: Studio
        self._looked_at = monotonic()
        self._files = {
            entry.name: entry.read_bytes()
            for entry in (files("rig.watching") / "page").iterdir()
            if entry.name.rpartition(".")[2] in _KINDS
        }

    async def serve(self, port: int, started: Callable[[int], None]) -> None:
        """Serve until cancelled, or until nobody is left.

        Parameters
        ----------
        port : int
            That is wanted; another one if it is taken, 0 for any.
        started : callable
            ``started(port)`` when the page can be opened.
        """
        logging.getLogger("aiohttp").setLevel(logging.CRITICAL)  # strangers write no log here
        listener = _listen(port)
        port = listener.getsockname()[1]
        self._gate = Gate(port)
        self._studio = Studio(self._followed, self._steering, self._beside)
        app = web.Application(middlewares=[self._guard], client_max_size=LONGEST)
        app.router.add_get("/", self._page)
        app.router.add_get("/page/{name}", self._file)
        app.router.add_get("/favicon.ico", self._icon)
        app.router.add_get("/ws", self._socket)
        app.router.add_post("/stop", self._stop)
        runner = web.AppRunner(
            app, access_log=None, handle_signals=False, keepalive_timeout=15.0,
            shutdown_timeout=_TO_LEAVE,
        )  # fmt: skip
        await runner.setup()
        await web.SockSite(runner, listener).start()
        started(port)
        try:
            await self._studio.work(self._is_left)
        finally:
            await runner.cleanup()
            self._studio.cameras.close()
            for followed in (self._followed, self._beside):
                if followed is not None:
                    followed.close()

    def _is_left(self) -> bool:
        if self._studio.viewers or self._followed.is_live:
            self._looked_at = monotonic()
        return self._leaves and monotonic() - self._looked_at > _LEAVES_AFTER

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Let nobody in who asks under another name, or from another page."""
        if not self._gate.knows_host(request.headers.getall("Host", [])):
            return _refusal(421, "This server is asked for by another name.")
        origins = request.headers.getall("Origin", [])
        changes = request.method != "GET" or request.path == "/ws"
        if (origins or changes) and not self._gate.knows_origin(origins, request.host):
            return _refusal(403, "Not from this page.")
        try:
            return await handler(request)
        except web.HTTPException as error:
            return _refusal(error.status, error.reason)

    async def _page(self, _: web.Request) -> web.Response:
        return self._sent("index.html")

    async def _icon(self, _: web.Request) -> web.Response:
        return web.Response(status=204, headers=HEADERS)

    async def _file(self, request: web.Request) -> web.Response:
        name = request.match_info["name"]
        if name not in self._files:
            return _refusal(404, "There is no such file.")
        return self._sent(name)

    def _sent(self, name: str) -> web.Response:
        kind = _KINDS[name.rpartition(".")[2]]
        headers = {**HEADERS, "Content-Security-Policy": policy(framed=False)}
        return web.Response(
            body=self._files[name], content_type=kind, charset="utf-8", headers=headers
        )

    async def _stop(self, request: web.Request) -> web.Response:
        """Stop the run; no token is asked for."""
        try:
            how = (await request.post()).get("how")
        except (ValueError, LookupError, web.RequestPayloadError):  # it is no form
            how = None
        if not isinstance(how, str) or how not in _STOPS:
            return _refusal(400, "How is the run to be stopped?")
        try:
            request_stop(self._path, at_once=_STOPS[how])
            said = f"{datetime.now().astimezone():%H:%M:%S}: asked to stop, {how}"
        except RigError as error:
            said = str(error)
        return _said(200, said)

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if self._studio.viewers >= _MOST_VIEWERS:
            return _refusal(503, "Too many pages look on.")
        transport = request.transport
        if not isinstance(transport, asyncio.Transport):
            return _refusal(400, "There is no connection.")
        kernel = transport.get_extra_info("socket")
        kernel.setsockopt(sockets.SOL_SOCKET, sockets.SO_SNDBUF, _KERNEL_BUFFER)
        socket = web.WebSocketResponse(max_msg_size=LONGEST, compress=False, autoping=True)
        await socket.prepare(request)
        self._studio.viewers += 1
        try:
            looks, steers = await self._rights(socket)
            if not looks:
                await asyncio.wait_for(socket.close(code=4401, message=b"token"), 1.0)
                return socket
            await Viewer(socket, transport, self._studio, steers, self.tokens.look).serve()
        except TimeoutError:
            transport.abort()
        finally:
            self._studio.viewers -= 1
        return socket

    async def _rights(self, socket: web.WebSocketResponse) -> tuple[bool, bool]:
        """Return what the first message of a page permits."""
        message = await asyncio.wait_for(socket.receive(), _TO_OPEN)
        if message.type is not WSMsgType.TEXT:
            return False, False
        try:
            told = parse(message.data, 0)
        except BadMessage:
            return False, False
        return self.tokens.rights(str(told.get("token", "")))


def _listen(port: int) -> sockets.socket:
    """Return a listener on loopback, on this port or, if it is taken, on any."""
    for wanted in (port, 0):
        listener = sockets.socket(sockets.AF_INET, sockets.SOCK_STREAM)
        listener.setsockopt(sockets.SOL_SOCKET, sockets.SO_REUSEADDR, 1)
        try:
            listener.bind((_LOOPBACK, wanted))
            listener.listen(64)
        except OSError:
            listener.close()
            if not wanted:
                raise
        else:
            listener.setblocking(False)
            return listener
    raise OSError("there is no free port")


def _said(status: int, sentence: str) -> web.Response:
    """Return a page of one sentence."""
    return web.Response(
        status=status,
        text='<!doctype html><html lang="en"><meta charset="utf-8"><title>rig</title>'
        '<link rel="stylesheet" href="/page/style.css"><body class="said">'
        f"<p>{html.escape(sentence)}</p></body></html>",
        content_type="text/html",
        headers={**HEADERS, "Content-Security-Policy": policy(framed=True)},
    )


def _refusal(status: int, sentence: str) -> web.Response:
    return _said(status, sentence)


def serve_run(
    run: Path,
    beside: Path | None,
    port: int,
    tell: Callable[[str, str | None], None],
    *,
    steer: bool,
    leaves: bool,
) -> None:
    """Serve the page of a run until Ctrl-C, or until nobody is left.

    Parameters
    ----------
    run, beside : Path
        Its folder, and that of another run to be laid under it.
    port : int
        That is wanted.
    tell : callable
        ``tell(look, steer)`` gets the addresses when they can be opened.
    steer : bool
        Whether gains may be changed.
    leaves : bool
        End when the run has ended and nobody has looked on for a minute.

    Raises
    ------
    ConfigurationError
        It is not a run folder.
    """
    os.nice(5)  # whoever looks on takes nothing from the run
    server = WatchServer(run, beside, steer=steer, leaves=leaves)

    def started(bound: int) -> None:
        address = f"http://{_LOOPBACK}:{bound}/#"
        tokens = server.tokens
        tell(address + tokens.look, None if tokens.steer is None else address + tokens.steer)

    async def serve() -> None:
        task = asyncio.current_task()
        assert task is not None
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                asyncio.get_running_loop().add_signal_handler(number, task.cancel)
        with contextlib.suppress(asyncio.CancelledError):
            await server.serve(port, started)

    asyncio.run(serve())
