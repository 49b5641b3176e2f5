"""How soon each chamber's pressure follows a step."""

from typing import Final

from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, MeasuredValue, StepResult, require_within
from rig.mechanisms.pneumatic.commissioning.chambers import LOWEST, Chambers, energised

_HIGHER, _LESS_HIGH = 14e3, 12e3
"""What all chambers are asked for in a step from the lowest, Pa gauge: of regulators, and of loops
around valves, which overshoot."""
_BEGINS: Final = 0.466
"""From 15 to 63 % a second-order response with a damping of 1 takes 1.467 over its bandwidth, and
to 15 % it takes 0.683: this share of it. What is left of the time to 15 % is dead."""
_LATE, _CREEPS = 0.02, 0.5
"""So much later than expected a regulator may answer, and the loop around a valve, which creeps
where next to nothing flows, s."""


class ResponseTimes(AcceptanceStep):
    """A step of every setpoint at once: how soon the monitors follow."""

    name = "response"
    does = (
        "Every chamber goes from 8 kPa to 14 kPa (on valves 12 kPa) above the least setpoint, "
        "in one step."
    )
    expects = (
        "Each monitor follows as fast as the profile's regulator_response says, dead time and all."
    )

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        settings = site.profile.mechanism_settings
        model = settings.regulator_response
        slack, higher = (_LATE, _HIGHER) if settings.valves is None else (_CREEPS, _LESS_HIGH)
        expected = model.dead_time + 2.15 / model.bandwidth  # to 63 % at a damping of 1
        with energised(site) as chambers:
            times = _step_times(chambers, higher)
            channels = chambers.regulators.channels
        measured = []
        for channel, (began, took) in zip(channels, times, strict=True):
            dead = began - _BEGINS * (took - began)
            measured.append(MeasuredValue(f"{channel}: dead time", max(dead, 0.0), "s"))
            name = f"{channel}: time to 63 % of a step"
            value = MeasuredValue(name, took, "s", high=1.8 * expected + slack)
            defect = "sticky or slow valve: it follows much later than the profile says"
            measured.append(require_within(channel, value, defect))
        return StepResult(tuple(measured))


def _step_times(chambers: Chambers, higher: float) -> list[tuple[float, float]]:
    """Return after how long each monitor has gone 15 and 63 % of a step, s; a second at most."""
    chambers.set_all(LOWEST + chambers.lift)
    low = chambers.rises()
    chambers.ask((higher + chambers.lift,) * len(low))
    rows = chambers.watch(1.0)
    high = chambers.rises()
    times = []
    for k, (zero, first, last) in enumerate(zip(chambers.zeros, low, high, strict=True)):
        began, took = (
            next((t for t, pressures in rows if pressures[k] >= level), 1.0)
            for level in (zero + first + share * (last - first) for share in (0.15, 0.63))
        )
        times.append((began, took))
    return times
