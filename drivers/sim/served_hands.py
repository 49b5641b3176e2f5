"""Hands at a rig that `rig simulate` simulates, for an acceptance test in another process.

A person at a real rig presses the stop, pulls a cable and reads a gauge. At a simulated one in
another process that is asked for over a local socket, in JSON. As a camera's, it has a name of
Linux's abstract kind: what reaches the virtual interface reaches it too.
"""

import json
import socket
from collections.abc import Sequence
from typing import Final

from drivers.sim.emulated_rig import EmulatedRig
from rig.hal import AiryPlant, HandledPlant

MOST: Final = 65536
"""Bytes of a request or an answer."""


def hands_address(channel: str) -> str:
    """Return the socket of the hands at a rig by its first interface."""
    return f"\0rig-simulate-hands/{channel}"


def serve_hands(world: EmulatedRig, channel: str) -> "tuple[ServedHands, ...]":
    """Return the hands at a rig; nobody if another simulation on this interface has them."""
    try:
        return (ServedHands(world, channel),)
    except OSError:
        return ()


class ServedHands:
    """The simulation's side; an end for `drivers.sim.wall_clock.WallClockRig`.

    Parameters
    ----------
    world : EmulatedRig
        Whose devices are broken and whose plant is looked at.
    channel : str
        The rig's first interface.

    Raises
    ------
    OSError
        Another simulation on this interface has hands.
    """

    def __init__(self, world: EmulatedRig, channel: str) -> None:
        self._world = world
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._client: socket.socket | None = None
        try:
            self._listener.bind(hands_address(channel))
        except OSError:
            self._listener.close()
            raise
        self._listener.listen()
        self._listener.setblocking(False)

    def fileno(self) -> int:
        """Return what to wait for: nobody hurries hands, so the first word alone is waited for."""
        return self._listener.fileno()

    def take(self, origin: float) -> None:
        """Do nothing: see `give`."""

    def give(self) -> None:
        """Do what was asked for since the last look, in a world that is at this instant."""
        if self._client is None:
            try:
                self._client, _ = self._listener.accept()
            except BlockingIOError:
                return
            self._client.setblocking(False)
        try:
            request = self._client.recv(MOST)
            if request:
                self._client.send(json.dumps(self._answer(request)).encode())
                return
        except BlockingIOError:
            return
        except OSError:  # whoever asked has gone
            pass
        self._client.close()
        self._client = None

    def close(self) -> None:
        """Let go of the socket. Idempotent."""
        if self._client is not None:
            self._client.close()
        self._listener.close()

    def _answer(self, request: bytes) -> dict[str, object]:
        try:
            asked = json.loads(request)
            return {"is": self._do(asked["do"], asked.get("with", ()))}
        except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
            return {"refused": str(error) or type(error).__name__}

    def _do(self, what: str, given: Sequence[str | float | None]) -> object:
        plant = self._world.plant
        if what == "inject":
            device, fault, value = given
            self._world.inject(str(device), str(fault), None if value is None else float(value))
            return None
        if what == "known-faults":
            return self._world.known_faults
        if what == "columns":
            return plant.truth_columns
        if what == "truth":
            return [float(value) for value in plant.truth()]
        if what == "bubbling":
            return plant.bubbling() if isinstance(plant, AiryPlant) else ()
        if what == "put-back":
            if isinstance(plant, AiryPlant):
                plant.put_back()
            return None
        if what == "pull":
            if not isinstance(plant, HandledPlant):
                raise ValueError("the simulated plant has nobody who could pull it")
            channel, by = given
            plant.pull(str(channel), float(by or 0.0))
            return None
        raise ValueError(f"hands cannot {what!r}")
