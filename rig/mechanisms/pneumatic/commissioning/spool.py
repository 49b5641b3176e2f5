"""How far a spool goes for its signal, before anything rests on the loop around it."""

from typing import Final

from rig.commissioning.site import Site
from rig.commissioning.step import MeasuredValue, require_within
from rig.mechanisms.pneumatic.commissioning.chambers import energised

_SMALL: Final = (4e3, (6e3, 9e3))
"""From where to where the setpoint of a loop around a valve steps before it is given more, Pa."""
_OVERSHOOT: Final = 1.7
"""Highest monitor over what such a step asked for; uncalibrated valves come to 1.65, a spool whose
signal is two and a half times too large to 1.7 and more. What is less is calibrated."""


def overshoot_of(site: Site, number: int) -> MeasuredValue:
    """Return the most that a monitor showed over what was asked for; raise if that is too much."""
    base, levels = _SMALL
    most = 0.0
    with energised(site) as chambers:
        channel, zero = chambers.regulators.channels[number], chambers.zeros[number]
        for level in levels:
            chambers.set(chambers.alone(number, base), 0.3)
            chambers.ask(chambers.alone(number, level))
            shown = max(pressures[number] for _, pressures in chambers.watch(0.2))
            most = max(most, (shown - zero) / level)
            value = MeasuredValue(f"{channel}: overshoot of a step", most, "1", high=_OVERSHOOT)
            require_within(
                channel, value,
                "wrong scale of its setpoint: its spool goes much further than the profile says",
            )  # fmt: skip
    return value
