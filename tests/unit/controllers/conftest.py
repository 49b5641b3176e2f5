import math

import pytest

from controllers.cylinder.types import PairModel


@pytest.fixture
def model():
    """A pair of 16 mm cylinders with low-speed seals."""
    return PairModel(
        area=math.pi / 4 * (16e-3**2 - 5e-3**2),
        mass=0.138,
        base_pressure=0.12e6,
        pressure_min=0.0,
        pressure_max=0.5e6,
        regulator_bandwidth=40.0,
        regulator_damping=1.0,
        coulomb=6.5,
        breakaway=6.7,
        stribeck_velocity=3e-3,
        viscous=30.0,
    )
