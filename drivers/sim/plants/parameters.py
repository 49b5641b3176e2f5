"""From a plant's settings and a seed to the parameters of its units."""

import math

import numpy as np

from drivers.sim.plants.channel import PARAMETERS
from drivers.sim.plants.regulator_settings import RegulatorSettings, TubeSettings
from drivers.sim.plants.settings import (
    SEALS,
    ActuatorSettings,
    SealFriction,
    WireSettings,
)
from drivers.sim.plants.tube import SEGMENTS, rise_per_mass, segment_numbers


def draw_channel(
    rng: np.random.Generator,
    *,
    regulator: RegulatorSettings,
    cylinder: ActuatorSettings,
    wire: WireSettings,
    seals: SealFriction,
    tube: TubeSettings,
    friction_spread: float,
    dead_steps: float,
) -> tuple[float, ...]:
    """Return one channel's `PARAMETERS`: the settings and this unit's deviations.

    The draws come in a fixed order and are always made, so that a setting does not change
    what other settings draw.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the deviations.
    regulator, cylinder, wire, seals, tube
        The nominal unit.
    friction_spread : float
        Bound of the relative deviation of the seals' friction.
    dead_steps : float
        This unit's dead time in steps of the plant.
    """
    linearity, bandwidth, friction = rng.uniform(-1.0, 1.0, 3)
    full_scale = regulator.full_scale
    unit_friction = 1.0 + friction_spread * friction
    segment = segment_numbers(tube.length / SEGMENTS, tube.bore)
    tube_volume = math.pi / 4.0 * tube.bore**2 * tube.length
    values = {
        "full_scale": full_scale,
        "hysteresis": regulator.hysteresis * full_scale,
        "bow": regulator.linearity * linearity,
        "bandwidth": regulator.bandwidth * (1.0 + regulator.bandwidth_spread * bandwidth),
        "damping": regulator.damping,
        "pilot_rate": regulator.pilot_rate,
        "dead_band": regulator.dead_band * full_scale,
        "band": regulator.proportional_band * full_scale,
        "valve_time": regulator.valve_time,
        "conductance_in": regulator.conductance_in,
        "conductance_out": regulator.conductance_out,
        "critical_ratio": regulator.critical_ratio,
        **body_values(cylinder, wire, seals, unit_friction),
        "dead_steps": dead_steps,
        "sampling": regulator.sampling,
        "repeatability": regulator.repeatability * full_scale,
        "least": regulator.least,
        "switched": float(regulator.pilot == "switched"),
        "pilot_period": regulator.pilot_period,
        "pilot_filter": regulator.pilot_filter,
        "monitor_time": regulator.monitor_time,
        "tube_length": tube.length,
        "tube_push": segment.push,
        "tube_drag": segment.drag,
        "tube_unit": segment.unit,
        "tube_rise": rise_per_mass(tube_volume),
        "tube_volume": tube_volume,
        "outlet_volume": tube.outlet,
    }
    return tuple(values[name] for name in PARAMETERS.names or ())


def body_values(
    cylinder: ActuatorSettings, wire: WireSettings, seals: SealFriction, friction: float
) -> dict[str, float]:
    """Return the parameters of a channel's cylinder and wire; `friction` is this unit's factor."""
    return {
        "area": math.pi / 4.0 * (cylinder.bore**2 - cylinder.rod**2),
        "stroke": cylinder.stroke,
        "dead_volume": cylinder.dead_volume,
        "mass": cylinder.mass,
        "coulomb": seals.coulomb * friction,
        "breakaway": seals.breakaway * friction,
        "stribeck_velocity": seals.stribeck_velocity,
        "viscous": seals.viscous * friction,
        "pressure_friction": seals.pressure * friction,
        "bristle_stiffness": cylinder.bristle_stiffness,
        "bristle_damping": cylinder.bristle_damping,
        "stop_stiffness": cylinder.stop_stiffness,
        "stop_damping": cylinder.stop_damping,
        "wire_stiffness": wire.stiffness,
        "wire_damping": wire.damping,
    }


def scale_seals(
    name: str, scale: float, stribeck_scale: float = 1.0, load_scale: float = 1.0
) -> SealFriction:
    """Return the seals of that name with all friction multiplied by `scale`.

    The Stribeck velocity has a factor of its own, and so has what grows with the pressure, besides.
    """
    nominal = SEALS[name]
    return SealFriction(
        coulomb=nominal.coulomb * scale,
        breakaway=nominal.breakaway * scale,
        stribeck_velocity=nominal.stribeck_velocity * stribeck_scale,
        viscous=nominal.viscous * scale,
        pressure=nominal.pressure * scale * load_scale,
        seat=nominal.seat * scale,
    )
