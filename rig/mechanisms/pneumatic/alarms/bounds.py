"""Bounds of the pressure alarms, from what a profile knows of its regulators."""

from typing import Final, NamedTuple

from rig.hal.quantities import Expected
from rig.mechanisms.pneumatic.alarms.settings import PressureAlarm
from rig.mechanisms.pneumatic.settings import PneumaticSettings, RegulatorModel, check_can_trip

STATIC: Final = 0.022
"""Share of the pressure range by which a regulator at rest is off: linearity 1 %, hysteresis and
repeatability 0.5 % each, sensitivity 0.2 %. C: electro-pneumatic regulators of 0.5 MPa."""
LOOP: Final = 0.005
"""Share of the range that is lost where the setpoint turns round: the width of the hysteresis."""
_SETTLING: Final = 2.0
"""Time constants after which a pressure that was pushed away is back, for the most part."""
_UNASKED: Final = 0.1
"""Share of the permitted time for which a pressure may be where nobody asked it to go: one that
falls throws its pair within tens of milliseconds."""
_STRAY: Final = 3.0
"""Of what a regulator at rest is off: rods that slip change a pressure by 1.3 of it …"""
_PUSHED: Final = 5e-3
"""… and who is pushed compresses air by more for less than so long, s: of what feeds a chamber so
quickly that it would be asked sooner, more is permitted."""
_FINE: Final = 0.01
"""Steps of a response that is worked out, in time constants …"""
_LONG: Final = 12.0
"""… and for how many of them: it is over."""


class PressureBounds(NamedTuple):
    """Bounds in force: what the profile says, else what follows; see `PressureAlarm`.

    Parameters
    ----------
    deviation : float
        Pa.
    time : float
        s.
    stray : float
        Pa; stands for `deviation` where nothing late explains a pressure.
    unasked : float
        s; stands for `time` there.
    offset : float
        Pa.
    slow : float
        Share of the deviation of a regulator of half the bandwidth.
    loop : float
        Pa; by it and `slow` times that deviation a healthy regulator may be off while it moves.
    """

    deviation: float
    time: float
    stray: float
    unasked: float
    offset: float
    slow: float
    loop: float


def check_pressure_alarm(alarm: PressureAlarm, settings: PneumaticSettings) -> None:
    """Refuse bounds that no pressure could be off by: a chamber has at most what may be set.

    Raises
    ------
    ValueError
        An alarm could never trip.
    """
    most, why = settings.limits.pressure[1], "may be set"
    if alarm.deviation is not None:
        check_can_trip("alarms.pressure.deviation", alarm.deviation, most, "Pa", why)
    name = "alarms.pressure.offset"
    if alarm.offset is None:
        name += f", {100 * STATIC:g} % of regulator_response.full_scale"
    check_can_trip(name, _chosen(alarm.offset, STATIC * settings.full_scale), most, "Pa", why)


def derive_bounds(alarm: PressureAlarm, settings: PneumaticSettings) -> PressureBounds:
    """Return the bounds in force; `PressureAlarm` says how they follow."""
    response = settings.regulator_response
    low = settings.limits.pressure[0]
    static = STATIC * settings.full_scale
    base = settings.base_pressure
    step = max(settings.greatest_pressure - base, base - low)
    slowest = response.spread / (1.0 - response.spread)
    late = 0.5 * response.dead_time * response.bandwidth / response.damping
    time = _chosen(alarm.time, _SETTLING / response.bandwidth)
    deviation = _chosen(alarm.deviation, static + step * greatest_difference(response))
    offset = _chosen(alarm.offset, static)
    return PressureBounds(
        deviation,
        time,
        min(_STRAY * offset * max(_PUSHED / (_UNASKED * time), 1.0), deviation),
        _UNASKED * time,
        offset,
        _chosen(alarm.slow, slowest + late),
        LOOP * settings.full_scale,
    )


def expect_bounds(bounds: PressureBounds) -> tuple[Expected, ...]:
    """Return what `rig check` says of them."""
    return (
        Expected("alarm: a pressure off a healthy regulator by", bounds.deviation, "Pa"),
        Expected("alarm: and for longer than", bounds.time, "s"),
        Expected("alarm: or off all that a late regulator does, by", bounds.stray, "Pa"),
        Expected("alarm: and for longer than", bounds.unasked, "s"),
        Expected("alarm: the mean of a pressure at rest off by", bounds.offset, "Pa"),
        Expected("alarm: a regulator slower, in share of its time, by", bounds.slow, "1"),
        Expected("alarm: and off, where it turns round, by", bounds.loop, "Pa"),
    )


def greatest_difference(response: RegulatorModel) -> float:
    """Return how far the slowest healthy regulator is off the model after a step, over the step.

    It has the model's bandwidth less the spread, and answers after the dead time.
    """
    time = _FINE / response.bandwidth
    slowed = 1.0 - response.spread
    dead = round(response.dead_time / time)
    model, late = _Answer(_FINE, response.damping), _Answer(_FINE * slowed, response.damping)
    greatest = 0.0
    for k in range(round(_LONG / _FINE)):
        model.step()
        if k >= dead:
            late.step()
        greatest = max(greatest, model.value - late.value)
    return greatest


class _Answer:
    """Answer of a second order to a step of 1; `turn`: its bandwidth times the time of a step."""

    def __init__(self, turn: float, damping: float) -> None:
        self.value = self._rate = 0.0
        self._turn, self._brake = turn, 1.0 / (1.0 + 2.0 * damping * turn)

    def step(self) -> None:
        """Go on by one step."""
        self._rate = (self._rate + self._turn * (1.0 - self.value)) * self._brake
        self.value += self._turn * self._rate


def _chosen(said: float | None, follows: float) -> float:
    return follows if said is None else said
