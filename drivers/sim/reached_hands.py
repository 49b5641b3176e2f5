"""A simulated world in another process, as far as hands and eyes at the rig reach."""

import json
import select
import socket
from collections.abc import Callable, Mapping
from typing import Any, Final, NoReturn, TypeAlias

from drivers.sim.served_hands import MOST, hands_address
from rig.hal import AiryPlant, ConnectionFailed, HandledPlant, Vector
from rig.hal.world import BreakableWorld, Frames

Answer: TypeAlias = Any
"""What hands say, out of JSON."""
_PATIENCE: Final = 10.0
"""For an answer, which takes a few milliseconds, s."""


def reach_hands(channel: str) -> "ReachedWorld | None":
    """Return the world of the simulation on an interface; None: nobody simulates a rig there."""
    link = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        link.connect(hands_address(channel))
    except OSError:
        link.close()
        return None
    return ReachedWorld(link)


class ReachedPlant(HandledPlant, AiryPlant):
    """The plant of a world in another process, as hands and eyes reach it.

    Parameters
    ----------
    ask : callable
        ``ask(what, *given)`` returns an answer.
    """

    def __init__(self, ask: Callable[..., Answer]) -> None:
        self._ask = ask
        self.truth_columns = tuple((str(name), str(unit)) for name, unit in ask("columns"))
        self.known_faults: tuple[str, ...] = tuple(ask("known-faults")["plant"])
        self.channel_names: tuple[str, ...] = ()

    def truth(self) -> Vector:
        """Return what is true now, in the order of `truth_columns`; SI."""
        return tuple(self._ask("truth"))

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault of the plant happen now."""
        self._ask("inject", "plant", fault, value)

    def pull(self, channel: str, by: float) -> None:
        """Move what a channel measures a little by hand; see `HandledPlant.pull`."""
        self._ask("pull", channel, by)

    def put_back(self) -> None:
        """Put all back where it was at first; see `AiryPlant.put_back`."""
        self._ask("put-back")

    def bubbling(self) -> tuple[str, ...]:
        """Return where soap water bubbles; see `AiryPlant.bubbling`."""
        return tuple(self._ask("bubbling"))

    def advance(self, t: float) -> None:
        """Do nothing: its time passes by itself."""


class ReachedWorld(BreakableWorld):
    """A world of `rig simulate`.

    Parameters
    ----------
    link : socket
        To its hands.
    """

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self.time = 0.0  # whoever looks, looks now
        self.plant = ReachedPlant(self._ask)

    def advance(self, t: float) -> None:
        """Do nothing: its time passes by itself."""

    @property
    def known_faults(self) -> Mapping[str, tuple[str, ...]]:
        """See `BreakableWorld.known_faults`."""
        return {name: tuple(faults) for name, faults in self._ask("known-faults").items()}

    def inject(self, device: str, fault: str, value: float | None = None) -> None:
        """See `BreakableWorld.inject`."""
        self._ask("inject", device, fault, value)

    def frames_of(self, device: str) -> Frames | None:
        """Return None: hands see no frames."""

    def disturb(
        self,
        bus: str,
        kind: str,
        can_id: int,
        value: float,
        changed: Callable[[], None] | None = None,
    ) -> NoReturn:
        """Refuse: hands reach no frames.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError(f"hands cannot {kind} frames of {bus}")

    def close(self) -> None:
        """Let go of the hands."""
        self._link.close()

    def _ask(self, what: str, *given: object) -> Answer:
        """Return what hands answer.

        Raises
        ------
        ConnectionFailed
            The simulation has ended, or does not answer.
        ValueError
            It refuses.
        """
        reply = b""
        try:
            self._link.send(json.dumps({"do": what, "with": given}).encode())
            if select.select([self._link], (), (), _PATIENCE)[0]:
                reply = self._link.recv(MOST)
        except OSError as error:
            raise ConnectionFailed("hands", f"the simulation has ended: {error}") from error
        if not reply:
            raise ConnectionFailed("hands", "the simulation has ended, or does not answer")
        answer = json.loads(reply)
        if "refused" in answer:
            raise ValueError(answer["refused"])
        return answer["is"]
