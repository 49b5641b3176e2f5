"""Gains of the cascade."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Gt, Le, Unit

from controllers.cylinder.feedforward import FeedforwardSettings


@dataclass(frozen=True, slots=True)
class CascadeSettings:
    """Bandwidths of the loops, of the observer and of the lead.

    The defaults are tuned for standard seals at 1 kHz; low-speed seals take less.

    Parameters
    ----------
    position_rate : float
        Velocity asked for over the position error, rad/s.
    velocity_rate : float
        Acceleration asked for over the velocity error, rad/s.
    tuned_viscous : float, optional
        Viscous friction of the pair that `velocity_rate` was tuned with, N s/m. Friction damps the
        pair, so with more of it the loop stays stable at a higher rate. The rate is multiplied by
        the fourth root of the calibrated friction over this one, a ratio that is kept between 0.5
        and 2. With 0.7 and with 1.3 times the friction, other powers track less well on the
        simulated joint. None: the rate does not depend on the friction.
    integral : float
        N/(m s), while the reference moves.
    hold_integral : float
        N/(m s), while it rests and the pair sticks. It then is a spring of some 4e5 N/m (the
        bristles of its contacts), on which the integral that suits sliding would take ten
        seconds; on a pair that slides this one would oscillate.
    observer_bandwidth : float
        rad/s; it follows the encoder: 800 to 1200 for 1 µm, two to three times less for 5 to
        10 µm.
    force_trust : float
        Share of the measured force that drives the observer's mass. With 1 a fast change of the
        force in a pair that still sticks is taken for motion until the disturbance has followed,
        ``3 F' / (M w²)``, and the monitors' noise gets into the velocity; with 0 the velocity
        comes from the encoders alone. The disturbance counts the whole force either way.
    lead_bandwidth : float
        Of the low-pass behind which the regulators' dynamics are inverted, rad/s.
    disturbance_gain : float
        Share of what the observer sees beyond the feedforward that is compensated at once; 0
        leaves it to the integral.
    disturbance_bandwidth : float
        Of that compensation, rad/s.
    trim_rate : float
        How fast the regulators' static error is trimmed by their monitors, rad/s.
    trim_limit : float
        Greatest differential that the trim adds, Pa: no more than two regulators may be off by
        linearity and hysteresis, because a pressure that does not follow is not to be chased.
    delay : float, optional
        From the readings to the moment that they are used for, s: the state is predicted over
        it. None: one period, as on a bus that is read at the end of a cycle.
    anticipation : float
        Share of the regulators' dead time by which the state and the reference are predicted
        besides: what is asked for now acts only then. 0: none; `rig tune` finds it.
    pressure_floor : float
        No setpoint goes below, Pa gauge, so that no wire goes slack.
    differential_limit : float, optional
        Greatest differential setpoint, Pa: head-room of the lead. Beyond what the floor leaves
        around the base pressure one chamber goes on alone, and the mean rises for moments. None:
        the mean stays.
    feedforward : FeedforwardSettings
        Inertia and friction of the desired motion.
    """

    position_rate: Annotated[float, Unit("rad/s"), Ge(0)] = 120.0
    velocity_rate: Annotated[float, Unit("rad/s"), Ge(0)] = 700.0
    tuned_viscous: Annotated[float, Unit("N s/m"), Gt(0)] | None = None
    integral: Annotated[float, Unit("N/(m s)"), Ge(0)] = 8.0e4
    hold_integral: Annotated[float, Unit("N/(m s)"), Ge(0)] = 4.5e5
    observer_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(5000)] = 1200.0
    force_trust: Annotated[float, Ge(0), Le(1)] = 0.2
    lead_bandwidth: Annotated[float, Unit("rad/s"), Gt(0), Le(3000)] = 600.0
    disturbance_gain: Annotated[float, Ge(0), Le(1)] = 0.1
    disturbance_bandwidth: Annotated[float, Unit("rad/s"), Gt(0)] = 40.0
    trim_rate: Annotated[float, Unit("rad/s"), Ge(0), Le(30)] = 3.0
    trim_limit: Annotated[float, Unit("Pa"), Ge(0)] = 15e3
    delay: Annotated[float, Unit("s"), Ge(0)] | None = None
    anticipation: Annotated[float, Ge(0), Le(2)] = 0.0
    pressure_floor: Annotated[float, Unit("Pa"), Ge(0)] = 20e3
    differential_limit: Annotated[float, Unit("Pa"), Gt(0)] | None = None
    feedforward: FeedforwardSettings = field(
        default_factory=lambda: FeedforwardSettings(error_rate=2.0)
    )
