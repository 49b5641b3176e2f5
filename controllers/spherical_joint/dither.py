"""Dither against stick-slip: in the tensions that turn nothing, or along the ring's path.

Seals stick and slip below the speed at which their friction stops falling. What helps depends on
the speed of the wires:

*Tension dither*, for creeping. Shaken, seals slide all the time and show the mean of their
friction, which rises with speed. All four wires are pulled harder and softer together, in the
shares that turn the ring nowhere, and the pistons work against the stretch of their wires.

*Path dither*, for sliding at some 5 to 15 mm/s. There the friction falls so fast that a pair runs
away within 4 ms, sooner than regulators and valves can answer: no feedback holds it, and
the ring goes in slips at 10 to 15 Hz. The ball's friction damps it across its path and not along
it, so that is where it slips. A small force along the path at 50 Hz sets the pace of the slips:
each is then a few times shorter.
"""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.spherical_joint.geometry import Pair
from controllers.spherical_joint.types import JointModel

_RISE_TIME = 0.2
"""With which the dither grows from nothing, so that control starts without a jump, s."""
_REST_SPEED = 0.5e-3
"""Well below it (m/s) the path has no direction, and the path dither goes."""


@dataclass(frozen=True, slots=True)
class DitherSettings:
    """Amplitude and frequency of the dither of the tensions.

    Parameters
    ----------
    amplitude : float
        Of the mean setpoint, Pa; 0 shakes nothing. The regulators let through a tenth of it at
        20 Hz.
    frequency : float
        How often a second the tensions are shaken, Hz.
    fade_speed : float
        Of the wires, m/s: well below it the dither is whole, beyond it it fades, because seals
        that slide need none.
    """

    amplitude: Annotated[float, Unit("Pa"), Ge(0)] = 0.0
    frequency: Annotated[float, Unit("Hz"), Gt(0), Le(100)] = 20.0
    fade_speed: Annotated[float, Unit("m/s"), Gt(0)] = 15e-3


@dataclass(frozen=True, slots=True)
class PathDitherSettings:
    """Amplitude and frequency of the dither along the path.

    Parameters
    ----------
    force : float
        Amplitude at the wires, N; 0 shakes nothing. It passes the regulators' lead: at 50 Hz a
        newton takes 340 kPa of difference between a pair's setpoints, and what is more than they
        have is cut off.
    frequency : float
        Hz. The higher, the shorter the slips, as long as the regulators follow.
    fade_speed : float
        Of the wires, m/s: well below it the dither is whole, beyond it it fades, because seals
        that slide need none.
    """

    force: Annotated[float, Unit("N"), Ge(0), Le(5)] = 0.0
    frequency: Annotated[float, Unit("Hz"), Gt(0), Le(100)] = 50.0
    fade_speed: Annotated[float, Unit("m/s"), Gt(0)] = 50e-3


class _FadingSine:
    """A sine that grows from nothing and fades with the speed of the wires."""

    def __init__(
        self, amplitude: float, frequency: float, fade_speed: float, period: float
    ) -> None:
        self._amplitude = amplitude
        self._per_fade = 1.0 / fade_speed
        self._step = math.tau * frequency * period
        self._rise = 1.0 - math.exp(-period / _RISE_TIME)
        self.reset()

    def reset(self) -> None:
        """Start with the sine's upward zero, from nothing."""
        self._phase = 0.0
        self._share = 0.0

    def update(self, speed: float) -> float:
        """Return the next value at a speed of the wires, m/s."""
        self._phase = (self._phase + self._step) % math.tau
        self._share += self._rise * (1.0 - self._share)
        fade = speed * self._per_fade
        return self._share * self._amplitude * math.exp(-fade * fade) * math.sin(self._phase)


class TensionDither:
    """A sine in the sum of the tensions.

    Parameters
    ----------
    settings : DitherSettings
        Amplitude, frequency and fading.
    model : JointModel
        Area and regulators.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: DitherSettings, model: JointModel, period: float) -> None:
        frequency = settings.frequency
        self._shakes = settings.amplitude > 0.0
        self._sine = _FadingSine(
            4.0 * model.area * settings.amplitude, frequency, settings.fade_speed, period
        )
        ratio = math.tau * frequency / model.regulator_bandwidth
        passed = math.hypot(1.0 - ratio * ratio, 2.0 * model.regulator_damping * ratio)
        self.tension = model.area * settings.amplitude / passed
        """By which the dither lowers the tension of a wire with a quarter of the sum, N."""

    def reset(self) -> None:
        """Start anew, from nothing."""
        self._sine.reset()

    def update(self, speed: float) -> float:
        """Return what is added to the sum of the tensions (N) at a speed of the wires, m/s."""
        return self._sine.update(speed) if self._shakes else 0.0


class PathDither:
    """A sine in the force along the ring's path.

    Parameters
    ----------
    settings : PathDitherSettings
        Force, frequency and fading.
    period : float
        The loop's period, s.
    """

    def __init__(self, settings: PathDitherSettings, period: float) -> None:
        self._shakes = settings.force > 0.0
        self._sine = _FadingSine(settings.force, settings.frequency, settings.fade_speed, period)

    def reset(self) -> None:
        """Start anew, from nothing."""
        self._sine.reset()

    def update(self, first: float, second: float) -> Pair:
        """Return what is added to the force of each pair, N.

        Parameters
        ----------
        first, second : float
            Velocities that the pairs should have, m/s.
        """
        if not self._shakes:
            return 0.0, 0.0
        speed = math.hypot(first, second)
        scale = self._sine.update(speed) / (speed + _REST_SPEED)
        return scale * first, scale * second
