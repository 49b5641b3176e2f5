"""Twists from a gamepad: read in a thread, so that no cycle ever waits for it."""

import select
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from annotated_types import Gt, Interval, Unit

from controllers.arm.on_direction.numbers import Six
from controllers.arm.online.commands import ArmTwists
from controllers.arm.online.twist_file import Row
from controllers.arm.types import AT_REST
from controllers.motion import InfeasibleMotion
from rig.hal.device_files import device_trouble, may_open, permitting
from rig.installation import installing

if TYPE_CHECKING:
    from evdev import InputDevice

_LOOK = 0.01
"""So often the thread looks, s; each time it says that the gamepad is there."""
_HELD = 0x136
"""BTN_TL, the left shoulder button: nothing moves unless it is held."""
_STICKS = {0x01: (0, -1), 0x00: (1, -1), 0x04: (2, -1), 0x03: (5, -1)}
"""Axes: ABS_Y, ABS_X, ABS_RY, ABS_RX; the entry of the twist, and its sign when pushed away."""
_KEYS, _AXES = 0x01, 0x03
"""Types of events: EV_KEY and EV_ABS."""
_DROPPED = (0x00, 0x03)
"""SYN_DROPPED: the kernel has thrown events away, perhaps that the button was let go."""
_HATS = {0x10: (3, 1), 0x11: (4, 1)}
"""ABS_HAT0X and ABS_HAT0Y: the tool's turning about x and y."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GamepadTwists(ArmTwists):
    """Twists from a gamepad, by evdev.

    Left stick: x and y. Right stick: z, and turning about z. Cross: turning about x and y. The left
    shoulder button has to be held.

    Parameters
    ----------
    device : str
        As ``/dev/input/event5``; the first gamepad that there is if left out.
    speed, turn_rate : float
        With a stick at its end, m/s and rad/s.
    dead_zone : float
        Share of a stick's way that counts as its middle.
    """

    device: str = ""
    speed: Annotated[float, Unit("m/s"), Gt(0)] = 0.1
    turn_rate: Annotated[float, Unit("rad/s"), Gt(0)] = 0.5
    dead_zone: Annotated[float, Interval(ge=0, lt=1)] = 0.1

    @property
    def real_time(self) -> bool:
        """See `ArmTwists.real_time`."""
        return True

    def known(self) -> list[Row] | None:
        """Return nothing; refuse to begin without a gamepad.

        Raises
        ------
        InfeasibleMotion
            There is none, or evdev is not installed.
        """
        _open(self.device).close()
        return None

    def listen(self) -> "GamepadThread":
        """Begin to read; see `ArmTwists.listen`."""
        return GamepadThread(_open(self.device), self)

    def twist(self, t: float) -> None:
        """Return nothing: the thread is asked, which `listen` begins."""
        del t


class GamepadThread:
    """The thread that reads a gamepad.

    Parameters
    ----------
    device : InputDevice
        Open.
    scale : GamepadTwists
        What the sticks mean.
    """

    def __init__(self, device: "InputDevice[str]", scale: GamepadTwists) -> None:
        self._device, self._scale = device, scale
        self._sticks = [0.0] * len(AT_REST)
        self._held = False
        self._ends = {code: device.absinfo(code) for code in (*_STICKS, *_HATS)}
        self._said: Six | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._read, name="gamepad", daemon=True)
        self._thread.start()

    def twist(self, t: float) -> Six | None:
        """Return what has been said since the last call; never waits."""
        del t
        said, self._said = self._said, None
        return said

    def leave(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join(timeout=1.0)
        self._device.close()

    def _read(self) -> None:
        while not self._stop.is_set():
            try:
                ready, _, _ = select.select([self._device.fd], [], [], _LOOK)
                for event in self._device.read() if ready else ():
                    self._take(event.type, event.code, event.value)
            except (OSError, ValueError):  # it is gone, and nobody need wait for the silence
                self._said = AT_REST
                return
            self._said = self._twist()

    def _take(self, kind: int, code: int, value: int) -> None:
        if kind == _KEYS and code == _HELD:
            self._held = bool(value)
        if (kind, code) == _DROPPED:  # nothing is known any more: press the button again
            self._held, self._sticks = False, [0.0] * len(AT_REST)
        entry = {**_STICKS, **_HATS}.get(code)
        if kind != _AXES or entry is None:
            return
        place, sign = entry
        ends = self._ends[code]
        middle, half = 0.5 * (ends.max + ends.min), 0.5 * (ends.max - ends.min)
        way = (value - middle) / half if half else 0.0
        dead = self._scale.dead_zone
        far = max(abs(way) - dead, 0.0) / (1.0 - dead)
        self._sticks[place] = sign * (far if way >= 0.0 else -far)

    def _twist(self) -> Six:
        if not self._held:
            return AT_REST
        v, w = self._scale.speed, self._scale.turn_rate
        x, y, z, a, b, c = self._sticks
        return (v * x, v * y, v * z, w * a, w * b, w * c)


def _open(path: str) -> "InputDevice[str]":
    """Return a gamepad.

    Raises
    ------
    InfeasibleMotion
        There is none, or evdev is not installed.
    """
    try:
        import evdev
    except ImportError as error:
        raise InfeasibleMotion(
            "arm-gamepad reads the gamepad by evdev, which is not installed: "
            f"{installing('evdev')}."
        ) from error
    found = path
    try:
        for found in [path] if path else evdev.list_devices():
            device = evdev.InputDevice(found)
            if _is_gamepad(device):
                return device
            device.close()
    except OSError as error:
        why = device_trouble(Path(found)) or str(error)
        raise InfeasibleMotion(f"the gamepad {found} cannot be read: {why}.") from error
    if path:
        raise InfeasibleMotion(
            f"{path} is no gamepad: it lacks two sticks, a cross or the left shoulder button."
        )
    closed = [file for file in sorted(Path("/dev/input").glob("event*")) if not may_open(file)]
    why = f", and {closed[0]} may not be read: {permitting(closed[0])}" if closed else ""
    raise InfeasibleMotion(f"there is no gamepad among /dev/input/event*: plug one in{why}.")


def _is_gamepad(device: "InputDevice[str]") -> bool:
    can = device.capabilities(absinfo=False)
    return _HELD in can.get(_KEYS, ()) and {*_STICKS, *_HATS} <= set(can.get(_AXES, ()))
