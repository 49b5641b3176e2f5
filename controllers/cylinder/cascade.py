"""Cascade of position and velocity loops on an observer that is fed with measured pressures."""

from controllers.base import Tunable
from controllers.cylinder.cascade_law import CascadeLaw
from controllers.cylinder.cascade_settings import CascadeSettings
from controllers.cylinder.numeric_law import NumericPairLaw


class Cascade(NumericPairLaw[CascadeSettings]):
    """Position over velocity over force, with an observer, feedforward, integral and lead.

    Notes
    -----
    Taking its parts away one by one on the simulated pair shows that lead, integral, friction
    feedforward and a fast observer fed with the measured force carry it.
    """

    Settings = CascadeSettings
    Numbers = CascadeLaw
    tunables = (
        Tunable("position_rate", 2.0, 250.0),
        Tunable("velocity_rate", 5.0, 700.0),
        Tunable("integral", 1e2, 2e5),
        Tunable("hold_integral", 1e2, 5e5),
        Tunable("observer_bandwidth", 150.0, 2500.0),
        Tunable("force_trust", 0.02, 1.0),
        Tunable("lead_bandwidth", 60.0, 1000.0),
        Tunable("disturbance_gain", 0.01, 1.0),
        Tunable("disturbance_bandwidth", 3.0, 200.0),
        Tunable("anticipation", 0.1, 2.0),
        Tunable("feedforward.gain", 0.3, 1.3),
        Tunable("feedforward.distance", 2e-6, 300e-6),
        Tunable("feedforward.learning_rate", 0.05, 10.0),
        Tunable("feedforward.error_rate", 0.05, 50.0),
    )
    online = (
        Tunable("position_rate", 2.0, 250.0),
        Tunable("velocity_rate", 5.0, 1000.0),
        Tunable("integral", 0.0, 4e5),
        Tunable("hold_integral", 0.0, 1e6),
        Tunable("disturbance_gain", 0.0, 1.0),
        Tunable("disturbance_bandwidth", 3.0, 200.0),
        Tunable("feedforward.gain", 0.0, 1.3),
    )
