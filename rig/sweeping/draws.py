"""Values that are drawn: every drawn axis of a sweep is one coordinate of the same samples.

The first values stay what they are when more are asked for, and an axis keeps its uniform or
normal values whatever axes stand beside it: adding draws runs only what is new.
"""

import hashlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.hal import ConfigurationError
from rig.sweeping.axis import Axis, DrawnAxis, with_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MAX_SOBOL: Final = 21_201
"""Dimensions for which direction numbers are known (S. Joe, F. Y. Kuo, 2008)."""


def draw_axes(axes: Sequence[DrawnAxis], seed: int) -> tuple[Axis, ...]:
    """Draw the values of axes.

    Parameters
    ----------
    axes : sequence of DrawnAxis
        All with the same count.
    seed : int
        Of the draws.

    Raises
    ------
    ConfigurationError
        Their counts differ.
    """
    counts = {axis.draws for axis in axes}
    if len(counts) > 1:
        told = ", ".join(f"{axis.setting} {axis.draws}" for axis in axes)
        raise ConfigurationError(f"axes that are drawn take as many values each: {told}")
    sobol = [axis for axis in axes if axis.kind == "sobol"]
    columns = dict(zip((axis.setting for axis in sobol), _sobol(sobol, seed), strict=True))
    return tuple(_axis(axis, columns.get(axis.setting), seed) for axis in axes)


def _axis(axis: DrawnAxis, shares: "NDArray[np.float64] | None", seed: int) -> Axis:
    if axis.kind == "normal":
        values = axis.low + axis.high * _chance(axis, seed).standard_normal(axis.draws)
    else:
        if shares is None:
            shares = _chance(axis, seed).random(axis.draws)
        values = axis.low + (axis.high - axis.low) * shares
    return Axis(axis.setting, tuple(with_unit(float(x), axis.unit) for x in values), axis.written)


def _chance(axis: DrawnAxis, seed: int) -> np.random.Generator:
    own = hashlib.sha256(axis.setting.encode()).digest()[:8]
    return np.random.default_rng([seed, int.from_bytes(own, "big")])


def _sobol(axes: Sequence[DrawnAxis], seed: int) -> "NDArray[np.float64]":
    """Return the shares of scrambled Sobol samples, one row for each axis."""
    if not axes:
        return np.empty((0, 0))
    if len(axes) > _MAX_SOBOL:
        raise ConfigurationError(f"{len(axes)} sobol axes; there may be {_MAX_SOBOL:,}")
    from scipy.stats import qmc

    # A power of two is balanced; the first of more are the same.
    exponent = (axes[0].draws - 1).bit_length()
    sampler = qmc.Sobol(len(axes), scramble=True, rng=np.random.default_rng(seed))
    samples: NDArray[np.float64] = sampler.random_base2(exponent)[: axes[0].draws]
    return samples.T
