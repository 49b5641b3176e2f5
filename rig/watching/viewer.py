"""One page that looks on: what it is sent, and what it asks for."""

import asyncio
import json
from time import monotonic
from typing import TYPE_CHECKING, cast

import numpy as np
from aiohttp import WSMsgType, web

from rig.watching.followed_run import FollowedRun, joined
from rig.watching.messages import BESIDE, FRAMES, ROWS, BadMessage, Request, pack, parse
from rig.watching.studio import Studio

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from rig.watching.followed_run import Times, Values
    from rig.watching.picture import Plain

PATIENCE = 10.0
"""A page that has not said for so long what it has heard is dropped, s."""
_MOST_UNHEARD = 30
"""Messages that may be on their way to a page; a page that is slower gets fewer, not more."""
_STATUS_EVERY = 2
"""Of so many ticks of the studio one brings the status."""
_LIVE_ROWS = 400
"""Rows in one message at most; more are sent as the extremes of stretches."""
_HISTORY_ROWS = 4000
_MOST_VALUES = 500_000
"""In one answer: what it takes to make and send it is bounded, whatever a page asks for."""
_MOST_BAD = 20
_CHUNK = 50
"""Frames that are worked out before others get their turn."""


class Viewer:
    """Serves one web socket, until it closes or stops listening.

    What a page does not read costs a bounded amount of memory: it says which messages it has
    heard, and while too many are on their way it is sent none.

    Parameters
    ----------
    socket : WebSocketResponse
        Prepared, of a page that has shown its token.
    abort : callable
        Ends the connection without waiting for anything.
    studio : Studio
        What is shown.
    steers : bool
        Whether the page may change gains.
    look : str
        The token for looking, which a link to a moment carries whoever copies it.
    """

    def __init__(
        self,
        socket: web.WebSocketResponse,
        transport: asyncio.Transport,
        studio: Studio,
        steers: bool,
        look: str,
    ) -> None:
        self._socket, self._transport = socket, transport
        self._studio, self._steers, self._look = studio, steers, look
        self._sent = self._heard = 0
        self._heard_at = monotonic()
        self._columns: NDArray[np.intp] = np.empty(0, np.intp)
        self._following: int | None = None
        self._row = 0
        self._events = 0
        self._described = 0
        self._bad = 0
        self._changing: asyncio.Task[None] | None = None

    async def serve(self) -> None:
        """Send and listen until the page is gone."""
        pushing = asyncio.create_task(self._push())
        listening = asyncio.create_task(self._listen())
        try:
            await asyncio.wait({pushing, listening}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            tasks = [pushing, listening, *([self._changing] if self._changing else [])]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self._transport.abort()

    async def _push(self) -> None:
        studio = self._studio
        tick = 0
        while True:
            if self._sent - self._heard > _MOST_UNHEARD:
                if monotonic() - self._heard_at > PATIENCE:
                    return
                await studio.next_tick()
                continue
            if monotonic() - self._heard_at > PATIENCE:
                return
            if self._described != studio.generation:
                self._described = studio.generation
                await self._say(self._described_to_it())
                for picture in studio.cameras.last.values():
                    await self._send(picture)
            await self._push_events()
            if tick % _STATUS_EVERY == 0:
                await self._say(studio.status())
            await self._push_rows()
            for packed in (*studio.new_frames, *studio.new_pictures):
                await self._send(packed)
            tick += 1
            await studio.next_tick()

    def _described_to_it(self) -> "Plain":
        return self._studio.described() | {"steers": self._steers, "look": self._look}

    async def _push_events(self) -> None:
        run = self._studio.run
        known = max(self._events - run.first_event, 0)
        fresh = run.events[known:]
        if fresh:
            self._events = run.first_event + len(run.events)
            await self._say({"type": "events", "events": fresh})

    async def _push_rows(self) -> None:
        run = self._studio.run
        if self._following is None or run.count <= self._row:
            return
        t, values = run.window(self._row, run.count, self._columns, _LIVE_ROWS)
        self._row = run.count
        await self._send(pack(ROWS, self._following, t, values))

    async def _listen(self) -> None:
        async for message in self._socket:
            if message.type is not WSMsgType.TEXT:
                self._bad += 1
            else:
                try:
                    await self._answer(parse(message.data, len(self._studio.run.columns)))
                except BadMessage as error:
                    self._bad += 1
                    await self._say({"type": "refused", "message": str(error)})
            if self._bad > _MOST_BAD:
                return

    async def _answer(self, request: Request) -> None:
        match request["type"]:
            case "here":
                heard = cast("int", request["heard"])
                if self._heard < heard <= self._sent:
                    self._heard = heard
                    self._heard_at = monotonic()
            case "follow":
                await self._follow(request)
            case "view":
                await self._view(request)
            case "beside":
                await self._beside(request)
            case "frames":
                await self._frames(request)
            case "gain" | "hold" if not self._steers:
                raise BadMessage("this page may look, and not steer")
            case "hold":
                self._studio.steer(request)
            case "gain" if self._changing is not None and not self._changing.done():
                await self._say({"type": "steered", "message": "one change after another"})
            case "gain":  # not waited for: whoever holds on says so meanwhile
                self._changing = asyncio.create_task(self._change(request))
            case _:
                raise BadMessage("the page is open already")

    async def _change(self, request: Request) -> None:
        """Hand a change of a gain on, once it has been thought about."""
        answer = await asyncio.to_thread(self._studio.steer, request)
        await self._say({"type": "steered", "message": answer})

    async def _follow(self, request: Request) -> None:
        """Send what there is of some columns, and whatever comes after it."""
        run = self._studio.run
        self._columns = np.array(request["columns"], np.intp)
        number = self._following = cast("int", request["id"])
        self._row = run.count
        if not run.count:
            return
        last = float(run.samples(np.array([run.count - 1]))[0][0])
        first = run.row_at(last - cast("float", request["seconds"]))
        most = min(_HISTORY_ROWS, _MOST_VALUES // max(len(self._columns), 1))
        t, values = run.window(first, self._row, self._columns, most)
        await self._send(pack(ROWS, number, t, values))

    async def _view(self, request: Request) -> None:
        """Send a window of the log."""
        columns = np.array(request["columns"], np.intp)
        t, values = await _window(self._studio.run, request, columns)
        await self._send(pack(ROWS, cast("int", request["id"]), t, values))

    async def _beside(self, request: Request) -> None:
        """Send the same window of the run beside it; columns that it lacks are no numbers.

        The same window of the motion: one rig may have taken longer to get to its start.
        """
        other = self._studio.beside
        if other is None:
            return
        index = {column.name: k for k, column in enumerate(other.columns)}
        names = [self._studio.run.columns[k].name for k in cast("list[int]", request["columns"])]
        known = np.array([name in index for name in names], bool)
        columns = np.array([index.get(name, 0) for name in names], np.intp)
        shift = self._studio.shift
        ends = {end: cast("float", request[end]) - shift for end in ("from", "to")}
        t, values = await _window(other, request | ends, columns)
        values = np.where(known, values, np.float32(np.nan))
        await self._send(pack(BESIDE, cast("int", request["id"]), t + shift, values))

    async def _frames(self, request: Request) -> None:
        """Send the scene at even steps of a window of the log."""
        run, picture = self._studio.run, self._studio.picture
        first = run.row_at(cast("float", request["from"]))
        last = max(run.row_at(cast("float", request["to"])), first)
        last = min(last, run.count - 1)
        count = min(cast("int", request["most"]), last - first + 1)
        if picture is None or not picture.is_drawn or count < 1:
            return
        numbers = np.unique(np.linspace(first, last, count).astype(np.intp))
        times, made = [], []
        for start in range(0, len(numbers), _CHUNK):
            t, values = run.samples(numbers[start : start + _CHUNK])
            times.append(t)
            made.append(picture.frames(values))
            await asyncio.sleep(0.0)
        packed = pack(
            FRAMES, cast("int", request["id"]), np.concatenate(times), np.concatenate(made)
        )
        await self._send(packed)

    async def _say(self, message: object) -> None:
        text = json.dumps(message, ensure_ascii=False, allow_nan=False)
        self._sent += 1
        await asyncio.wait_for(self._socket.send_str(text), PATIENCE)

    async def _send(self, content: bytes) -> None:
        self._sent += 1
        await asyncio.wait_for(self._socket.send_bytes(content), PATIENCE)


async def _window(
    run: FollowedRun, request: Request, columns: "NDArray[np.intp]"
) -> "tuple[Times, Values]":
    """Return the window of a log that a page asks for, and a row more at either end."""
    first = max(run.row_at(cast("float", request["from"])) - 1, 0)
    last = run.row_at(cast("float", request["to"])) + 1
    most = min(cast("int", request["most"]), _MOST_VALUES // max(len(columns), 1))
    found = []
    for piece in run.pieces(first, last, columns, max(most, 2)):
        found.append(piece)
        await asyncio.sleep(0.0)
    return joined(found, len(columns))
