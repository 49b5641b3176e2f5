"""Estimates with honest intervals: what a fit or a set of repetitions says, and how well."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rig.calibration.arrays import Array, Indices
from rig.calibration.recording import CalibrationRefused

CONFIDENCE = 0.95
"""Of every interval."""


class Estimate(NamedTuple):
    """A value with its uncertainty.

    Parameters
    ----------
    name : str
        Dotted, e.g. ``"agonist.setpoint.gain"``.
    value : float
        SI.
    unit : str
        SI unit, ``"1"`` for a ratio.
    std : float
        Standard deviation of the value, in `unit`.
    low, high : float
        95 % confidence interval.
    """

    name: str
    value: float
    unit: str
    std: float
    low: float
    high: float

    def inverse(self, name: str, unit: str) -> "Estimate":
        """Return the estimate of 1 over the value; the interval need not be symmetrical."""
        value = 1.0 / self.value
        std = value**2 * self.std
        return Estimate(name, value, unit, std, 1.0 / self.high, 1.0 / self.low)


class Fit(NamedTuple):
    """A least-squares fit.

    Parameters
    ----------
    values : ndarray, shape (p,)
        The parameters.
    covariance : ndarray, shape (p, p)
        Of the parameters.
    freedom : float
        Degrees of freedom that the covariance rests on as a whole.
    residuals : ndarray, shape (n,)
        Measured less fitted.
    blocks : sequence of ndarray, shape (n, p)
        How independent residuals would come into each block's part of the covariance; empty
        without blocks.
    """

    values: Array
    covariance: Array
    freedom: float
    residuals: Array
    blocks: Sequence[Array] = ()

    def freedom_of(self, gradient: Sequence[float]) -> float:
        """Return the degrees of freedom of a function of the parameters.

        With blocks it depends on the function: a parameter that two of ten blocks determine has
        little more than one, whatever the others do (Satterthwaite's approximation).

        Parameters
        ----------
        gradient : sequence of float, length p
            Of the function.
        """
        if not self.blocks:
            return self.freedom
        columns = np.column_stack([block @ np.asarray(gradient) for block in self.blocks])
        gram = columns.T @ columns
        return max(float(np.trace(gram) ** 2 / np.sum(gram**2)), 1.0)

    def estimate(self, name: str, unit: str, gradient: Sequence[float], value: float) -> Estimate:
        """Return an estimate of a function of the parameters.

        Parameters
        ----------
        name, unit : str
            See `Estimate`.
        gradient : sequence of float, length p
            Of the function.
        value : float
            Its value.
        """
        g = np.asarray(gradient)
        std = float(np.sqrt(g @ self.covariance @ g))
        return interval(name, value, unit, std, self.freedom_of(gradient))

    def parameter(self, index: int, name: str, unit: str) -> Estimate:
        """Return the estimate of one parameter."""
        unity = np.eye(len(self.values))[index]
        return self.estimate(name, unit, unity.tolist(), float(self.values[index]))


def interval(name: str, value: float, unit: str, std: float, freedom: float) -> Estimate:
    """Return an estimate whose interval comes from Student's distribution."""
    from scipy.stats import t

    half = float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * std
    return Estimate(name, value, unit, std, value - half, value + half)


def fit(
    residuals: Callable[[Array], Array],
    start: Sequence[float],
    scale: Sequence[float],
    *,
    groups: Array | Indices | None = None,
) -> Fit:
    """Fit parameters by least squares.

    Parameters
    ----------
    residuals : callable
        Measured less modelled for parameters of shape (p,), shape (n,).
    start, scale : sequence of float, length p
        First guess, and by how much each parameter typically varies.
    groups : ndarray, shape (n,), optional
        Which block each residual belongs to. Residuals of one block may depend on each other:
        the covariance is then the one that is robust against that, and its degrees of freedom
        follow from how much of a parameter each block determines. Without blocks the residuals
        are taken as independent.

    Raises
    ------
    ValueError
        There are too few residuals or blocks, or the data do not determine the parameters.

    References
    ----------
    R. M. Bell and D. F. McCaffrey, "Bias reduction in standard errors for linear regression with
    multi-stage samples", Survey Methodology 28(2), 2002: the blocks' residuals are enlarged by
    what the fit has taken from them (CR2: right for independent residuals, however unlike the
    blocks are), and the degrees of freedom of each parameter.
    """
    from scipy.optimize import least_squares

    found = least_squares(residuals, np.asarray(start, float), x_scale=np.asarray(scale, float))
    r, jacobian = found.fun, found.jac
    n, p = jacobian.shape
    norms = np.linalg.norm(jacobian, axis=0)
    if n <= p or not np.all(norms > 0.0) or np.linalg.cond(jacobian / norms) > 1e10:
        raise ValueError("the data do not determine every parameter")
    inverse = np.linalg.inv(jacobian.T @ jacobian)
    if groups is None:
        freedom = float(n - p)
        return Fit(found.x, inverse * float(r @ r) / freedom, freedom, r)
    names = np.unique(groups)
    if len(names) < 3:
        raise ValueError(f"{len(names)} blocks are too few to tell how well they repeat")
    projector = np.eye(n) - jacobian @ inverse @ jacobian.T
    meat = np.zeros((p, p))
    blocks = []
    for name in names:
        mine = groups == name
        part = _inverse_root(projector[np.ix_(mine, mine)]) @ jacobian[mine]
        score = part.T @ r[mine]
        meat += np.outer(score, score)
        blocks.append(projector[:, mine] @ part @ inverse)
    covariance = inverse @ meat @ inverse
    return Fit(found.x, covariance, float(len(names) - 1), r, blocks)


def fit_or_refuse(
    what: str,
    residuals: Callable[[Array], Array],
    start: Sequence[float],
    scale: Sequence[float],
    groups: Array | Indices | None = None,
) -> Fit:
    """Fit as `fit` does.

    Raises
    ------
    CalibrationRefused
        The data do not determine the parameters of `what`.
    """
    try:
        return fit(residuals, start, scale, groups=groups)
    except ValueError as error:
        raise CalibrationRefused(f"{what}: {error}") from error


def _inverse_root(matrix: Array) -> Array:
    """Return the inverse of a symmetric matrix's root; directions that the fit took whole are out.

    A block of which the fit has taken a direction altogether says nothing about it.
    """
    values, vectors = np.linalg.eigh(matrix)
    keep = values > 1e-9
    root = vectors[:, keep] / np.sqrt(values[keep])
    return np.asarray(root @ vectors[:, keep].T)


def differ(residuals: Array, groups: Array | Indices, sure: float) -> bool:
    """Return whether blocks of residuals differ by more than chance explains (F test).

    Parameters
    ----------
    residuals, groups : ndarray, shape (n,)
        And which block each one belongs to.
    sure : float
        Probability with which it is not said of blocks that are alike.
    """
    from scipy.stats import f

    names = np.unique(groups)
    parts = [residuals[groups == name] for name in names]
    within = sum(float(((part - part.mean()) ** 2).sum()) for part in parts)
    between = sum(len(part) * float(part.mean() - residuals.mean()) ** 2 for part in parts)
    over, under = len(names) - 1, len(residuals) - len(names)
    most = float(f.ppf(sure, over, under))
    return between / over > most * within / under


def welch(parts: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return standard deviation and degrees of freedom of a sum of independent errors.

    Parameters
    ----------
    parts : sequence of tuple
        Standard deviation and degrees of freedom of each.

    References
    ----------
    B. L. Welch, "The generalization of Student's problem when several different population
    variances are involved", Biometrika 34, 1947, pp. 28-35.
    """
    variance = sum(std**2 for std, _ in parts)
    weight = sum(std**4 / freedom for std, freedom in parts)
    freedom = variance**2 / weight if weight > 0.0 else sum(freedom for _, freedom in parts)
    return float(np.sqrt(variance)), freedom


def mean_of(name: str, unit: str, repetitions: Sequence[float]) -> Estimate:
    """Return the mean of independent repetitions with its interval.

    Raises
    ------
    ValueError
        There are fewer than two.
    """
    values = np.asarray(repetitions, float)
    if len(values) < 2:
        raise ValueError(f"{name}: one repetition cannot tell how well it repeats")
    std = float(values.std(ddof=1) / np.sqrt(len(values)))
    return interval(name, float(values.mean()), unit, std, len(values) - 1.0)


def middle_of(name: str, unit: str, one: Sequence[float], other: Sequence[float]) -> Estimate:
    """Return the middle between the means of two groups of repetitions, with its interval.

    The groups may scatter unlike each other: the degrees of freedom are Welch's, between those of
    the group that scatters more and those of both.

    Raises
    ------
    ValueError
        There are fewer than two in a group.
    """
    means = [mean_of(name, unit, values) for values in (one, other)]
    std, freedom = welch(
        [
            (0.5 * mean.std, len(values) - 1.0)
            for mean, values in zip(means, (one, other), strict=True)
        ]
    )
    return interval(name, 0.5 * sum(mean.value for mean in means), unit, std, freedom)
