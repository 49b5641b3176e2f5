"""What ends a program (Ctrl-C, SIGTERM …) as requests that the cycle reads at a safe point."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import Self

PATIENCE = 1.0
"""A cycle that has not heard a request for so long does not end by itself, s."""
ENDING = (
    signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1, signal.SIGUSR2,
    signal.SIGPWR,
)  # fmt: skip
"""Signals that somebody sends, or the host whose power fails, and that would end the program."""
UNHEARD = "in a cycle that did not end"


class StopRequests:
    """Counts requests to stop while active.

    Once asks for an orderly stop (the rig is lowered to its safe state at a bounded rate),
    twice for the safe state at once. While the loop is not `in_loop` (connecting, say, where
    nothing moves and a call may block) a request raises `KeyboardInterrupt` as usual.

    A cycle that computes without end hears neither. A further signal that comes `PATIENCE` after
    one that no cycle has `heard` raises `KeyboardInterrupt` in the midst of it, at most once in
    that time, and only `in_cycles`: what makes safe is not interrupted.

    Signals come to the main thread only: in another one nobody but `request` asks for a stop.
    """

    def __init__(self) -> None:
        self.count = 0
        self.heard = 0
        self.in_loop = False
        self.in_cycles = False
        self.shielded = False
        self._previous: dict[int, signal.Handlers | object] = {}

    def request(self) -> None:
        """Ask for a stop, as Ctrl-C does."""
        if self.count == self.heard:
            self._unheard_since = monotonic()
        self.count += 1

    def shield(self) -> None:
        """Only count from now on: what runs next must not be interrupted."""
        self.shielded = True

    @contextmanager
    def shielding_the_end(self) -> Iterator[None]:
        """Shield whatever comes after the block: a second request must not tear what closes."""
        try:
            yield
        finally:
            self.shield()

    def expose(self) -> None:
        """Let requests interrupt again; one that came meanwhile does so now."""
        self.shielded = False
        if self.count:
            raise KeyboardInterrupt

    def _handle(self, number: int, frame: FrameType | None) -> None:
        is_deaf = self.in_cycles and self.count > self.heard
        if is_deaf and monotonic() - self._unheard_since >= PATIENCE:
            self._unheard_since = monotonic()
            raise KeyboardInterrupt(UNHEARD)
        self.request()
        if not self.in_loop and not self.shielded:
            raise KeyboardInterrupt

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in ENDING:
            self._previous[number] = signal.signal(number, self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
