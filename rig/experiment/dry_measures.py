"""Whether an experiment's measures can be taken: tried on a made-up log before anything moves."""

import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from rig.experiment.measure import Measure, Samples
from rig.experiment.metrics import MetricRequest, check_value
from rig.experiment.windows import windows_of
from rig.hal import Column, ConfigurationError, ContractBroken
from rig.hal.fits import where
from rig.hal.motion import Segment
from rig.runtime.cycle import RUN_COLUMNS, TIMING_COLUMNS
from rig.runtime.log import Log, LogError

_INSTANTS = 9
"""Of each segment that are made up."""


def try_measures(
    metrics: Mapping[str, MetricRequest],
    measures: Mapping[str, Measure],
    segments: Sequence[Segment],
    columns: Sequence[Column],
    constants: Mapping[str, float],
) -> None:
    """Refuse a measure that takes a column that no run will record, or returns no number.

    What else a measure makes of numbers that mean nothing is not judged.

    Parameters
    ----------
    metrics : mapping of str to MetricRequest
        By the metric's name.
    measures : mapping of str to Measure
        Known ones; a metric that is not among them is a fact of the motion.
    segments : sequence of Segment
        Of the motion.
    columns : sequence of Column
        The mechanism's and the devices'. The plant's true values are not looked for.
    constants : mapping of str to float
        What the mechanism says of the rig.

    Raises
    ------
    ConfigurationError
        It takes a column that is not there.
    ContractBroken
        It returns no number.
    """
    made_up = _made_up(segments, (*RUN_COLUMNS, *columns, *TIMING_COLUMNS))
    samples = Samples(made_up, constants)
    for name, spec in metrics.items():
        known = spec.measure or name
        if known not in measures:
            continue
        measure = measures[known]
        windows = windows_of(samples, name, spec.segments, segments)
        try:
            with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore"):
                value = measure.compute(windows)
        except LogError as error:
            what = f"metric {name}: the measure {known} ({where(measure.compute)})"
            raise ConfigurationError(f"{what} cannot be taken: {error}") from error
        except ContractBroken:
            raise
        except Exception:
            continue
        check_value(name, known, measure, value)


def _made_up(segments: Sequence[Segment], columns: Sequence[Column]) -> Log:
    """Return a log with some instants of every segment, in which every number differs."""
    instants = [np.linspace(s.start, s.end, _INSTANTS) for s in segments]
    t = np.unique(np.concatenate(instants))
    values = 1e-2 + 1e-3 * np.random.default_rng(0).standard_normal((len(t), len(columns)))
    names = [column.name for column in columns]
    values[:, names.index("phase")] = 1.0
    values[:, names.index("reference.time")] = t
    numbers = np.arange(len(t), dtype=np.uint64)
    return Log(tuple(columns), numbers, t, values, numbers, complete=True)
