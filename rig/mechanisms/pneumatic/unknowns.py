"""What gains of a pneumatic mechanism have to bear, until a calibration has measured it."""

from typing import Final

from rig.hal.bench import Unknown

UNKNOWNS: Final = (
    # Seals differ and wear, and the supply's dew point changes them from day to day. E.
    Unknown(
        "friction", ("coulomb", "breakaway", "viscous"), "",
        guessed=(0.6, 1.6), measured=(0.85, 1.15), measured_by="friction",
    ),
    # Makers state the time of a step within a factor. E.
    Unknown(
        "bandwidth", ("regulator_bandwidth",), "",
        guessed=(0.67, 1.5), measured=(0.9, 1.1), measured_by="regulator_response",
    ),
    Unknown(
        "dead time", ("regulator_dead_time",), "s",
        guessed=(-3e-3, 3e-3), measured=(-1e-3, 1e-3), measured_by="regulator_response",
    ),
)  # fmt: skip
"""Of a pair, each with its bounds before and after it was measured."""

_OF_BALL = ("ring_friction", "wire_friction")

JOINT_UNKNOWNS: Final = (
    UNKNOWNS[0]._replace(numbers=(*UNKNOWNS[0].numbers, *_OF_BALL)),
    *UNKNOWNS[1:],
)
"""Of a joint: what is on the ball wears and dries as seals do."""
