"""Emulated servos behind a pseudo-terminal: any program may open it as a serial port."""

import os
import select
import tty
from collections.abc import Callable
from time import monotonic

from drivers.sim.dynamixel.chain import EmulatedChain
from drivers.sim.dynamixel.framing import InstructionReader

_CHUNK = 4096
_IDLE = 2e-3  # how often time passes for the servos while nobody speaks, s


class PseudoTerminal:
    """A chain of servos that answers on a pseudo-terminal, in the time of the wall clock.

    There is no bit time: an answer comes as fast as the machine can give it.

    Parameters
    ----------
    chain : EmulatedChain
        The servos.
    clock : callable
        Returns the time, s.
    advance : callable
        Lets the physics move on to a time, s.

    Attributes
    ----------
    path : str
        What the other program opens.
    """

    def __init__(
        self,
        chain: EmulatedChain,
        clock: Callable[[], float] = monotonic,
        advance: Callable[[float], None] = lambda now: None,
    ) -> None:
        self._chain = chain
        self._clock = clock
        self._advance = advance
        self._reader = InstructionReader()
        self._master, self._slave = os.openpty()
        # Kept open, so that the terminal lives on when its user closes it.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(self._slave)

    def serve(self, is_over: Callable[[], bool]) -> None:
        """Answer until it is over."""
        while not is_over():
            self.serve_once(_IDLE)

    def serve_once(self, wait: float) -> None:
        """Answer what has come, or let `wait` (s) pass if nothing comes."""
        ready, _, _ = select.select([self._master], [], [], wait)
        now = self._clock()
        self._advance(now)
        self._chain.tick(now)
        if not ready:
            return
        for packet in self._reader.take(os.read(self._master, _CHUNK)):
            answer = self._chain.handle(packet, now)
            if answer:
                os.write(self._master, answer)

    def unplug(self) -> None:
        """Pull the adapter out: the other program gets an input/output error."""
        self.close()

    def close(self) -> None:
        """Release the terminal. Idempotent."""
        for end in (self._master, self._slave):
            if end >= 0:
                os.close(end)
        self._master = self._slave = -1
