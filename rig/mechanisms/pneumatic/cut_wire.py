"""How fast a mechanism gets, and with what energy it meets its stop, if a wire is cut.

What is left of the mechanism is pulled by the chamber opposite the cut wire. The wire is cut at
rest, so nothing has to happen for that: half a metre a second is passed before anything could be
measured. Venting comes too late to change the speed, and the profile's numbers alone say it.
"""

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from rig.hal.formats import format_quantity
from rig.hal.quantities import Expected
from rig.mechanisms.pneumatic.pull import say_too_low
from rig.mechanisms.pneumatic.settings import PneumaticSettings

_STEP = 1e-4
"""Of the integration, s: a tenth of the cycle at 1 kHz, a thirtieth of mass over damping."""
_SEEN = 6e-3
"""From the cut to vented setpoints, s: what the alarms take on the simulated rigs."""
_LONGEST = 0.5
"""A regulator has vented its chamber by then, s."""
_NEAR = 1e-2
"""A pressure that moves by less from one look to the next is known, Pa."""
_FASTEST = 1e6
"""m/s: what absurd settings come to beyond it is no number that can be reckoned with."""
_PART = 1.0 / 3.0
"""Share of `moving_mass` that is one piston; as much is what two of them move. E."""

_SMOOTH = 0.6
"""Share of the friction that a profile says, which seals may have that nobody has measured. E."""
_SWING = 1.5
"""What the pair and the joint have at most, over the energy at the rod's own speed: wires are
springs, and let what they pull swing ahead. On the simulated pair it is 1.2, on the joint 1.4."""


class Whip(NamedTuple):
    """Speed and energy after a wire is cut.

    Parameters
    ----------
    speed : float
        Greatest speed of the rod opposite the cut wire, m/s.
    energy : float
        Greatest kinetic energy of all that still moves, J: the stop may be anywhere on its way.
    """

    speed: float
    energy: float


def compute_whip(settings: PneumaticSettings, wires: int, pressure: float) -> Whip:
    """Return what a wire that is cut comes to while the opposite chamber is at a pressure.

    Parameters
    ----------
    settings : PneumaticSettings
        Dimensions, friction and regulators.
    wires : int
        How many the mechanism has.
    pressure : float
        Of the chamber opposite the cut wire, Pa gauge.
    """
    friction, response = settings.friction, settings.regulator_response
    # One of the pair's two rods slides on, with half of the pair's friction.
    fastest = _fastest(
        pressure, settings.area, 2.0 * _PART * settings.moving_mass, settings.stroke,
        0.5 * friction.coulomb, 0.5 * friction.viscous, response.bandwidth, response.damping,
    )  # fmt: skip
    # All pistons but the one whose wire is cut, and what they move, at that rod's speed.
    moves = wires * _PART * settings.moving_mass
    return Whip(fastest, _SWING * 0.5 * moves * fastest**2)


@lru_cache  # a profile is checked several times on its way to a run
def _fastest(
    pressure: float, area: float, mass: float, stroke: float,
    coulomb: float, viscous: float, bandwidth: float, damping: float,
) -> float:  # fmt: skip
    """Return the greatest speed of a rod on its way to the end of its stroke, m/s."""
    pull, drag = _STEP * bandwidth**2, 2.0 * damping * bandwidth
    here, rate, speed, way, fastest = pressure, 0.0, 0.0, 0.0, 0.0
    for k in range(round(_LONGEST / _STEP)):
        if k * _STEP >= _SEEN:
            rate = (rate - pull * here) / (1.0 + _STEP * drag)
            here += _STEP * rate
        force = area * here - coulomb
        speed = max((speed + _STEP * force / mass) / (1.0 + _STEP * viscous / mass), 0.0)
        way += _STEP * speed
        fastest = max(fastest, speed)
        if way > stroke:
            break
    return fastest


def compute_calm_pressure(settings: PneumaticSettings, wires: int) -> float:
    """Return the pressure at which a cut wire just keeps ``limits.speed``, Pa gauge.

    By false position, after Illinois: scipy's root finder takes longer to import than all of
    `rig check`, and halving takes four times as many looks.
    """
    low, high = 0.0, settings.limits.pressure[1]
    slow, fast = (_excess(settings, wires, pressure) for pressure in (low, high))
    if fast <= 0.0:
        return high
    was_fast: bool | None = None
    moved = high
    while moved >= _NEAR:
        middle = high - fast * (high - low) / (fast - slow)
        excess = _excess(settings, wires, middle)
        is_fast = excess > 0.0
        moved = middle - low
        # An end that stays twice would stay for long: half of its excess draws the next look there.
        halved = 0.5 if is_fast is was_fast else 1.0
        if is_fast:
            high, fast, slow = middle, excess, halved * slow
        else:
            low, slow, fast = middle, excess, halved * fast
        was_fast = is_fast
    return low


def _excess(settings: PneumaticSettings, wires: int, pressure: float) -> float:
    return min(compute_whip(settings, wires, pressure).speed, _FASTEST) - settings.limits.speed


def compute_damper(settings: PneumaticSettings, pressure: float) -> float:
    """Return the damper at a rod that keeps ``limits.speed`` after a cut, N s/m; 0: needs none."""
    force = settings.area * pressure - 0.5 * settings.friction.coulomb
    return max(force / settings.limits.speed - 0.5 * settings.friction.viscous, 0.0)


def expect_cut_wire(
    settings: PneumaticSettings, wires: int, greatest: float
) -> tuple[Expected, ...]:
    """Return what `rig check` says of a cut wire.

    Parameters
    ----------
    settings : PneumaticSettings
        Of the mechanism.
    wires : int
        How many it has.
    greatest : float
        The greatest pressure that the profile permits in the chamber opposite, Pa gauge.
    """
    base = compute_whip(settings, wires, settings.base_pressure)
    most = compute_whip(settings, wires, greatest)
    smooth = compute_whip(_with_less_friction(settings), wires, greatest)
    calm = compute_calm_pressure(settings, wires)
    damper = compute_damper(settings, settings.base_pressure)
    warning = ""
    if base.speed > settings.limits.speed:
        warning = _say_too_fast(settings, calm, damper, most.energy)
    return (
        Expected("a cut wire at base_pressure: speed up to", base.speed, "m/s", warning),
        Expected("a cut wire at base_pressure: energy up to", base.energy, "J"),
        Expected("greatest pressure opposite a wire", greatest, "Pa"),
        Expected("a cut wire at the greatest pressure: speed up to", most.speed, "m/s"),
        Expected("a cut wire at the greatest pressure: energy up to", most.energy, "J"),
        Expected(f"the same with {_SMOOTH:g} of the friction", smooth.energy, "J"),
        Expected("base_pressure that keeps limits.speed", calm, "Pa"),
        Expected("or a damper at each rod", damper, "N s/m"),
    )


def _say_too_fast(settings: PneumaticSettings, calm: float, damper: float, energy: float) -> str:
    """Say what keeps `limits.speed`; a pressure only at which the pair can still be moved."""
    above = f"that is above limits.speed, {format_quantity(settings.limits.speed, 'm/s')}"
    pressure = (
        f"{format_quantity(calm, 'Pa')} (it is {format_quantity(settings.base_pressure, 'Pa')})"
    )
    at_rods = f"a damper of {format_quantity(damper, 'N s/m')} at each rod"
    if not (too_low := say_too_low(settings, calm)):
        return f"{above}: a base_pressure of at most {pressure} keeps it, or {at_rods}"
    return (
        f"{above}. A base_pressure that keeps it, {pressure}, is too low to move the seals: "
        f"{too_low}. What keeps it is {at_rods}; or let it be as fast (limits.speed), and have a "
        f"stop that bears {format_quantity(energy, 'J')} (limits.stop_energy)"
    )


def refuse_weak_stop(settings: PneumaticSettings, wires: int, greatest: float) -> str | None:
    """Say why the declared mechanical stop does not do for a cut wire; None: it does."""
    energy = compute_whip(settings, wires, greatest).energy
    declared = settings.limits.stop_energy
    if declared is not None and declared >= energy:
        return None
    mend = "Give the energy that the stop bears, once it has been built and tried"
    has = "is not declared"
    if declared is not None:
        has = f"is {declared:g} J"
        mend = (
            f"The stop is too weak: it takes one that bears {energy:.3g} J at least. It takes less "
            f"with a lower {settings.lowers_pressure}, or with a damper at each rod "
            "(friction.viscous)"
        )
    smooth = compute_whip(_with_less_friction(settings), wires, greatest).energy
    return (
        f"limits.stop_energy {has}: a wire that is cut throws the mechanism into its mechanical "
        f"stop with up to {energy:.3g} J ({greatest * 1e-3:.0f} kPa opposite it), and with "
        f"{smooth:.3g} J if its seals have {_SMOOTH:g} of the friction that the profile says, as "
        f"they may where nobody has measured it. {mend}"
    )


def _with_less_friction(settings: PneumaticSettings) -> PneumaticSettings:
    """Return the settings of a rig whose seals are smoother than anybody has told."""
    seals = settings.friction
    less = replace(seals, coulomb=_SMOOTH * seals.coulomb, viscous=_SMOOTH * seals.viscous)
    return replace(settings, friction=less)
