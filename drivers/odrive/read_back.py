"""What an armed ODrive axis must have, read back in the cycle."""

import struct
from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from drivers.odrive.client import OdriveClient
from drivers.odrive.settings import OdriveAxisSettings, OdriveSettings


class ArmedSetting(NamedTuple):
    """A parameter that an armed axis must have.

    Parameters
    ----------
    endpoint : int
        Its number.
    what : str
        Its name, for messages.
    layout : struct.Struct
        Of its value.
    value : float
        That it must have.
    """

    endpoint: int
    what: str
    layout: struct.Struct
    value: float


def armed_settings(shared: OdriveSettings, axis: OdriveAxisSettings) -> tuple[ArmedSetting, ...]:
    """Return what an axis loses when it reboots, as far as its endpoints are known."""
    numbers = shared.endpoints
    if numbers is None:
        return ()
    wanted: tuple[tuple[int | None, str, float, str], ...] = (
        (numbers.watchdog_timeout, "watchdog_timeout", shared.watchdog, "<f"),
        (numbers.enable_watchdog, "enable_watchdog", True, "<?"),
        (numbers.speed_limit, "vel_limit", axis.motor_speed_limit, "<f"),
        (numbers.current_limit, "current_soft_max", axis.current_limit, "<f"),
    )
    return tuple(
        ArmedSetting(number, what, struct.Struct(layout), value)
        for number, what, value, layout in wanted
        if number is not None
    )


class ReadBack:
    """Asks an axis for its settings, one after the other, and never waits.

    Parameters
    ----------
    client : OdriveClient
        Of the axis.
    settings : sequence of ArmedSetting
        That it must have.
    timeout : float
        After which it is asked again, s.
    """

    def __init__(
        self, client: OdriveClient, settings: Sequence[ArmedSetting], timeout: float
    ) -> None:
        self._client = client
        self._settings = tuple(settings)
        self._timeout = timeout
        self.restart()

    def restart(self) -> None:
        """Read all of them again."""
        self._left = list(self._settings)
        self._asks_at = -inf

    @property
    def is_done(self) -> bool:
        """Whether all are as they must be."""
        return not self._left

    def step(self, now: float) -> tuple[str, str, str] | None:
        """Take the answer, ask for the next one; return what is lost: parameter, value, bound."""
        if not self._left:
            return None
        setting = self._left[0]
        found = self._client.answered(setting.endpoint, setting.layout.size)
        if found and found != setting.layout.pack(setting.value):
            (value,) = setting.layout.unpack(found)
            thing = f"endpoint {setting.endpoint} ({setting.what})"
            return thing, f"{value:g}", f"{setting.value:g}"
        if found:
            self._left.pop(0)
            self._asks_at = -inf
        if self._left and now >= self._asks_at:
            self._asks_at = now + self._timeout
            self._client.request_parameter(self._left[0].endpoint)
        return None
