"""The stretches of a log that a metric is taken over."""

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np

from rig.experiment.measure import Samples, Window
from rig.hal import RigError
from rig.hal.motion import Segment


class MetricError(RigError):
    """A metric cannot be computed from this log."""


def windows_of(
    samples: Samples, metric: str, pattern: str, segments: Sequence[Segment]
) -> list[Window]:
    """Return the windows of a metric, one for each segment whose name a pattern matches.

    Raises
    ------
    MetricError
        There is no such segment, or the log does not hold it to its end.
    """
    chosen = [segment for segment in segments if fnmatchcase(segment.name, pattern)]
    if not chosen:
        raise MetricError(
            f"metric {metric}: no segment matches {pattern!r}; there are "
            + (", ".join(repr(segment.name) for segment in segments) or "none")
        )
    return [_window(samples, metric, segment) for segment in chosen]


def _window(samples: Samples, metric: str, segment: Segment) -> Window:
    """Cut a segment out; MetricError if the log does not hold it to its end."""
    t = samples.t
    first, last = np.searchsorted(t, [segment.start, segment.end])
    # The last sample of a run comes one period before its end; rounding may take another.
    reached = len(t) > 0 and t[-1] >= segment.end - 2.0 * samples.period
    if last <= first or not reached:
        end = f"{t[-1]:.3f} s" if len(t) else "before the reference started"
        raise MetricError(
            f"metric {metric}: segment {segment.name!r} lasts from {segment.start:.3f} to "
            f"{segment.end:.3f} s, but the log ends at {end}"
        )
    return Window(segment, samples, slice(int(first), int(last)))
