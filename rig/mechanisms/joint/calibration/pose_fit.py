"""A fit of parameters to data and priors, with the uncertainty of each parameter."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from rig.calibration.arrays import Array, Flags, Indices
from rig.calibration.error_sums import estimate_of_sum
from rig.calibration.estimates import Estimate
from rig.calibration.recording import CalibrationRefused
from rig.mechanisms.joint.calibration.parameters import Prior

_ROUNDS: Final = 4
_OUTLIER: Final = 6.0
"""Robust standard deviations beyond which a frame is no measurement: something was in the way."""

_LEAST_BLOCKS: Final = 6
_DOMINATED: Final = 0.7
"""Above this share of its prior's standard deviation a parameter is the drawing's."""


class Data(NamedTuple):
    """Measurements that a model has to explain.

    Parameters
    ----------
    misfit : callable
        Measured less modelled for parameters by name, whitened to a unit each, shape (n, m): one
        row per frame.
    blocks : ndarray of int, shape (n,)
        What belongs together: rows of one block may depend on each other.
    extra : callable
        Further measurements, each over its own standard deviation, independent; shape (k,).
    """

    misfit: Callable[[Mapping[str, float]], Array]
    blocks: Indices
    extra: Callable[[Mapping[str, float]], Array]


class Posterior(NamedTuple):
    """Parameters after the fit, with the parts of their uncertainty.

    Parameters
    ----------
    priors : sequence of Prior
        Of the parameters that were fitted.
    considered : sequence of Prior
        Of the parameters that were not.
    values : ndarray, shape (p,)
        The parameters.
    sampling : ndarray, shape (p, p)
        Covariance by the scatter of the data.
    even, normal : ndarray, shape (p, m)
        Change of the parameters by one standard deviation of each prior: of priors that are even
        within a tolerance, and of the others.
    freedom : float
        Degrees of freedom that the scatter rests on.
    used : ndarray of bool, shape (n,)
        Which rows were no outliers.
    """

    priors: Sequence[Prior]
    considered: Sequence[Prior]
    values: Array
    sampling: Array
    even: Array
    normal: Array
    freedom: float
    used: Flags

    @property
    def by_name(self) -> dict[str, float]:
        """The parameters."""
        values = dict(zip([p.name for p in self.priors], self.values.tolist(), strict=True))
        return values | {p.name: p.mean for p in self.considered}

    def std(self, name: str) -> float:
        """Return the standard deviation of a parameter."""
        k = self._index(name)
        known = self.even[k] @ self.even[k] + self.normal[k] @ self.normal[k]
        return float(np.sqrt(self.sampling[k, k] + known))

    def estimate(self, name: str, shown: str | None = None, shift: float = 0.0) -> Estimate:
        """Return a parameter with its interval, under another name and shifted if wanted."""
        k = self._index(name)
        return estimate_of_sum(
            shown or name, float(self.values[k]) + shift, self.priors[k].unit,
            float(np.sqrt(self.sampling[k, k])), self.freedom,
            float(np.linalg.norm(self.normal[k])), self.even[k].tolist(),
        )  # fmt: skip

    def _index(self, name: str) -> int:
        return [prior.name for prior in self.priors].index(name)

    @property
    def dominated(self) -> tuple[str, ...]:
        """The parameters that are known little better than by their priors."""
        return tuple(p.name for p in self.priors if self.std(p.name) > _DOMINATED * p.std)


def fit_posterior(priors: Sequence[Prior], data: Data, start: Mapping[str, float]) -> Posterior:
    """Fit parameters to data and priors.

    Notes
    -----
    The residuals of a block depend on each other: friction and what the model leaves out change
    slowly. So the data weigh as much less, beside the priors, as the blocks' scores scatter more
    than those of independent rows; the covariance of the estimate is ``H^-1 (M + B' B) H^-1``
    with the blocks' scores in M and in B the slopes of what was known beforehand, each over its
    standard deviation. A tolerance is no normal distribution: what lies anywhere within one
    enters the interval as that, and so does an error of what was considered and not fitted
    (Schmidt).

    Raises
    ------
    CalibrationRefused
        There are too few blocks, or the fit does not settle.

    References
    ----------
    R. M. Bell and D. F. McCaffrey, "Bias reduction in standard errors for linear regression with
    multi-stage samples", Survey Methodology 28(2), 2002 (CR3).
    S. F. Schmidt, "Application of state-space methods to navigation problems", Advances in Control
    Systems 3, 1966: parameters that are considered.
    """
    from scipy.optimize import least_squares

    considered = [p for p in priors if p.considered]
    priors = [p for p in priors if not p.considered]
    fixed = {p.name: p.mean for p in considered}
    names = [p.name for p in priors]
    mean, std = np.array([p.mean for p in priors]), np.array([p.std for p in priors])
    groups = np.unique(data.blocks)
    if len(groups) < _LEAST_BLOCKS:
        raise CalibrationRefused(
            f"{len(groups)} stretches are too few to tell how well they repeat, at least "
            f"{_LEAST_BLOCKS} are needed"
        )

    def at(q: Array) -> dict[str, float]:
        return fixed | dict(zip(names, (mean + std * q).tolist(), strict=True))

    q, wanted = (np.array([start[name] for name in names]) - mean) / std, 1.0
    used = np.ones(len(data.blocks), bool)
    for _ in range(_ROUNDS):
        weight = wanted

        def rest(q: Array, used: Flags = used, weight: float = weight) -> Array:
            values = at(q)
            rows = weight * data.misfit(values)[used].ravel()
            return np.concatenate([rows, data.extra(values), q])

        found = least_squares(rest, q, ftol=1e-6, xtol=1e-6, gtol=1e-6, max_nfev=60)
        if not found.success:
            raise CalibrationRefused(f"no joint explains what was recorded: {found.message}")
        q = found.x
        rows = data.misfit(at(q))
        kept = used
        used = _near(rows)
        count = np.count_nonzero(kept) * rows.shape[1]
        jacobian, score = found.jac[:count] / weight, found.fun[:count] / weight
        belief = found.jac[count:].T @ found.jac[count:]
        own = jacobian.T @ jacobian
        variance = float(score @ score) / max(count - np.linalg.matrix_rank(own), 1)
        hessian = weight * weight * own + belief
        inverse = np.linalg.inv(hessian)
        meat = _scatter(jacobian, score, data.blocks[kept], rows.shape[1], inverse, weight)
        # By how much more the blocks' scores scatter than those of independent rows.
        inflated = max(float(np.trace(inverse @ meat) / np.trace(inverse @ own)), variance)
        settled = abs(weight * np.sqrt(inflated) - 1.0) < 0.1 and bool((used == kept).all())
        if settled:
            break
        wanted = 1.0 / np.sqrt(inflated)
    known = inverse @ found.jac[count:].T * std[:, None]
    known, further = known[:, -len(q) :], known[:, : -len(q)]
    # Change of the parameters by an error of each considered one.
    slopes = [
        weight * data.misfit(at(q) | {p.name: p.mean + p.std})[kept].ravel() - found.fun[:count]
        for p in considered
    ]
    shifts = -(inverse @ found.jac[:count].T @ np.array(slopes).reshape(-1, count).T) * std[:, None]
    even, loose = np.array([p.even for p in priors]), np.array([p.even for p in considered], bool)
    return Posterior(
        priors, considered, mean + std * q,
        weight**4 * inverse @ meat @ inverse * np.outer(std, std),
        np.hstack([known[:, even], shifts[:, loose]]),
        np.hstack([known[:, ~even], shifts[:, ~loose], further]),
        len(groups) - 1.0, kept,
    )  # fmt: skip


def _near(rows: Array) -> Flags:
    size = np.abs(rows).max(axis=1)
    return np.asarray(size < _OUTLIER * 1.4826 * max(float(np.median(np.abs(rows))), 1e-12))


def _scatter(
    jacobian: Array, score: Array, blocks: Indices, width: int,
    inverse: Array, weight: float,
) -> Array:  # fmt: skip
    """Return the sum of the squares of the blocks' scores, enlarged by what the fit took away."""
    each = np.repeat(blocks, width)
    names = np.unique(blocks)
    size = jacobian.shape[1]
    meat = np.zeros((size, size))
    for name in names:
        part, rest = jacobian[each == name], score[each == name]
        # (I - J H^-1 J')^-1 r by Woodbury: a block has many rows, there are few parameters.
        square = weight * weight * (part.T @ part)
        gradient = part.T @ rest
        gradient = gradient + square @ np.linalg.solve(np.linalg.inv(inverse) - square, gradient)
        meat += np.outer(gradient, gradient)
    return np.asarray(meat * (len(names) - 1) / len(names))
