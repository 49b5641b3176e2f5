"""An experiment's metrics: a measure over some segments, held against a bound."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypedDict

from rig.assembly import REGISTRY
from rig.experiment.measure import Measure, NoSuchMotion, NoTruth, Samples
from rig.experiment.windows import MetricError, windows_of
from rig.hal import ContractBroken, RigError
from rig.hal.fits import is_number, is_ours, shown, where
from rig.hal.motion import Fact, Note, Segment
from rig.runtime.log import LogError

if TYPE_CHECKING:
    from rig.runtime.log_columns import LogColumns


class FactEntry(TypedDict):
    """A `Fact` of an ``evaluation.json``; the value of what never happens is null."""

    value: float | None
    unit: str
    description: str


class SegmentEntry(TypedDict):
    """A `Segment` of an ``evaluation.json``, s."""

    name: str
    start: float
    end: float


class SpecEntry(TypedDict, total=False):
    """A `RecordedSpec` of an ``evaluation.json``, SI."""

    measure: str | None
    segments: str
    max: float | None
    min: float | None


class RemarkEntry(TypedDict):
    """A remark of the planner on a motion, as ``evaluation.json`` has it."""

    kind: str
    message: str


class Evaluation(TypedDict, total=False):
    """The content of ``evaluation.json``: what is needed beside a log to judge and draw it."""

    mechanism: str | None
    additions: list[str]
    constants: dict[str, float]
    figures: list[str]
    facts: dict[str, FactEntry]
    remarks: list[RemarkEntry]
    segments: list[SegmentEntry]
    metrics: dict[str, SpecEntry]


class MetricRequest(Protocol):
    """A metric as an experiment asks for it.

    `measure` defaults to the metric's name, `segments` is a pattern of segment names, `max`
    and `min` are bounds in the measure's SI unit.
    """

    @property
    def measure(self) -> str | None: ...  # noqa: D102 - described above

    @property
    def segments(self) -> str: ...  # noqa: D102

    @property
    def max(self) -> float | None: ...  # noqa: D102

    @property
    def min(self) -> float | None: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class RecordedSpec:
    """A `MetricRequest` as a run folder keeps it."""

    measure: str | None
    segments: str = "*"
    max: float | None = None
    min: float | None = None


class Metric(NamedTuple):
    """A measured number and what was asked of it.

    Parameters
    ----------
    name : str
        The experiment's name for it.
    value : float
        SI; infinite if what it times never happened, NaN if it is not seen.
    unit : str
        SI unit, empty for a ratio.
    bound : float or None
        SI; None when the number is only reported.
    bound_kind : str or None
        ``"max"`` or ``"min"``.
    measure, segments : str
        Which measure was taken over which segments.
    is_seen : bool
        False: it takes the true state, which nobody could record.
    """

    name: str
    value: float
    unit: str
    bound: float | None
    bound_kind: str | None
    measure: str
    segments: str
    is_seen: bool = True

    @property
    def passed(self) -> bool | None:
        """Whether the bound holds, which NaN never does; None without a bound, or unseen."""
        if self.bound is None or not self.is_seen:
            return None
        return self.value <= self.bound if self.bound_kind == "max" else self.value >= self.bound

    def as_json(self) -> dict[str, Any]:
        """Return the entry of ``metrics.json``; a value that is no finite number is null there.

        One that was computed and is NaN says so, or it would be taken for what never happened.
        """
        entry = {
            "name": self.name,
            "value": self.value if math.isfinite(self.value) else None,
            "unit": self.unit,
            "bound": self.bound,
            "bound_kind": self.bound_kind,
            "pass": self.passed,
            "measure": self.measure,
            "segments": self.segments,
        }
        return {**entry, "is_nan": True} if self.is_seen and math.isnan(self.value) else entry


def evaluate(
    log: "LogColumns",
    segments: Sequence[Segment],
    specs: Mapping[str, MetricRequest],
    facts: Mapping[str, Fact] | None = None,
    mechanism: str | None = None,
    measures: Mapping[str, Measure] | None = None,
    constants: Mapping[str, float] | None = None,
) -> list[Metric]:
    """Compute an experiment's metrics from a log.

    Parameters
    ----------
    log : LogColumns
        With the columns ``phase`` and ``reference.time``, and those that the measures take.
    segments : sequence of Segment
        Those of the experiment's reference.
    specs : mapping of str to MetricRequest
        By the metric's name. One with both bounds gives two metrics, ``name`` for the upper
        and ``name.min`` for the lower.
    facts : mapping of str to Fact, optional
        What the motion's plan says of it; a metric may name one instead of a measure.
    mechanism : str, optional
        Whose own measures go before those of others.
    measures : mapping of str to Measure, optional
        More measures than are installed; they go before all others.
    constants : mapping of str to float, optional
        What is known of the rig, SI; see `rig.hal.Mechanism.constants_of`.

    Returns
    -------
    list of Metric
        In the order of `specs`, without those about a motion that no segment has and that nothing
        is asked of.

    Raises
    ------
    MetricError
        A measure is unknown, a pattern matches no segment, or the log does not hold a segment
        to its end: a number over half of it would look like one over all of it.
    """
    samples = Samples(log, constants or {})
    known = {**known_measures(mechanism), **(measures or {})}
    return [
        metric
        for name, spec in specs.items()
        for metric in evaluate_one(name, spec, samples, segments, known, facts or {})
    ]


def evaluate_one(
    name: str,
    spec: MetricRequest,
    samples: Samples,
    segments: Sequence[Segment],
    known: Mapping[str, Measure],
    facts: Mapping[str, Fact],
) -> list[Metric]:
    """Compute one of an experiment's metrics; see `evaluate`.

    Parameters
    ----------
    name : str
        The metric's.
    spec : MetricRequest
        What is asked of it.
    samples : Samples
        Of the log.
    segments : sequence of Segment
        Those of the experiment's reference.
    known : mapping of str to Measure
        Every measure.
    facts : mapping of str to Fact
        What the motion's plan says of it.
    """
    measure_name = spec.measure or name
    fact = facts.get(measure_name)
    if fact is not None:
        return _bounded(name, spec, measure_name, fact.value, fact.unit)
    measure = known.get(measure_name)
    if measure is None:
        raise MetricError(
            f"metric {name}: no measure is called {measure_name!r}; there are " + ", ".join(known)
        )
    windows = windows_of(samples, name, spec.segments, segments)
    try:
        value = measure.compute(windows)
    except NoTruth:
        return _bounded(name, spec, measure_name, math.nan, measure.unit, is_seen=False)
    except (ValueError, LogError) as error:
        if isinstance(error, NoSuchMotion) and spec.max is None and spec.min is None:
            return []
        raise MetricError(f"metric {name}: {error}") from error
    except RigError:
        raise
    except (Exception, SystemExit) as error:  # nobody's measure ends the program
        if is_ours(measure.compute):
            raise
        what = f"metric {name}: the measure {measure_name} ({where(measure.compute)})"
        raise ContractBroken(f"{what}: {type(error).__name__}: {error}") from error
    check_value(name, measure_name, measure, value)
    return _bounded(name, spec, measure_name, value, measure.unit)


def check_value(metric: str, name: str, measure: Measure, value: object) -> None:
    """Refuse what is no number.

    Raises
    ------
    ContractBroken
        With whose value it is.
    """
    if not is_number(value):
        what = f"metric {metric}: the measure {name} ({where(measure.compute)})"
        raise ContractBroken(f"{what} returned {shown(value)}, and no number")


def _bounded(
    name: str,
    spec: MetricRequest,
    measure: str,
    value: float,
    unit: str,
    *,
    is_seen: bool = True,
) -> list[Metric]:
    """Hold a value against the bounds that a specification gives: one metric for each."""
    bounds: list[tuple[str, float | None, str | None]] = []
    if spec.max is not None or spec.min is None:
        bounds.append((name, spec.max, "max" if spec.max is not None else None))
    if spec.min is not None:
        bounds.append((f"{name}.min" if bounds else name, spec.min, "min"))
    return [
        Metric(label, value, unit, bound, kind, measure, spec.segments, is_seen)
        for label, bound, kind in bounds
    ]


def known_measures(mechanism: str | None) -> Mapping[str, Measure]:
    """Return every measure by name; a mechanism's own go before those of others."""
    return REGISTRY.measures(mechanism, Measure)


def evaluation_as_json(
    segments: Sequence[Segment],
    specs: Mapping[str, MetricRequest],
    figures: Sequence[str] = (),
    facts: Mapping[str, Fact] | None = None,
    mechanism: str | None = None,
    constants: Mapping[str, float] | None = None,
    additions: Sequence[str] = (),
    remarks: Sequence[Note] = (),
) -> Evaluation:
    """Return what is needed beside the log to judge and draw it, for ``evaluation.json``."""
    return {
        "mechanism": mechanism,
        **({"additions": list(additions)} if additions else {}),
        "constants": dict(constants or {}),
        "figures": list(figures),
        "facts": {
            name: {
                "value": fact.value if math.isfinite(fact.value) else None,
                "unit": fact.unit,
                "description": fact.description,
            }
            for name, fact in (facts or {}).items()
        },
        **(
            {"remarks": [{"kind": kind, "message": said} for kind, said in remarks]}
            if remarks
            else {}
        ),
        "segments": [
            {"name": segment.name, "start": segment.start, "end": segment.end}
            for segment in segments
        ],
        "metrics": {
            name: {
                "measure": spec.measure,
                "segments": spec.segments,
                "max": spec.max,
                "min": spec.min,
            }
            for name, spec in specs.items()
        },
    }


def facts_from_json(content: Evaluation) -> dict[str, Fact]:
    """Return the facts of an ``evaluation.json``; what never happens is null there."""
    return {
        name: Fact(
            math.inf if fact["value"] is None else fact["value"], fact["unit"], fact["description"]
        )
        for name, fact in content.get("facts", {}).items()
    }


def constants_from_json(content: Evaluation) -> dict[str, float]:
    """Return what an ``evaluation.json`` knows of the rig, SI."""
    return {name: float(value) for name, value in content.get("constants", {}).items()}


def evaluation_from_json(
    content: Evaluation,
) -> tuple[tuple[Segment, ...], dict[str, RecordedSpec]]:
    """Return the segments and metric specifications of an ``evaluation.json``."""
    segments = tuple(
        Segment(entry["name"], entry["start"], entry["end"])
        for entry in content.get("segments", ())
    )
    specs = {
        name: RecordedSpec(
            spec.get("measure"), spec.get("segments", "*"), spec.get("max"), spec.get("min")
        )
        for name, spec in content.get("metrics", {}).items()
    }
    return segments, specs


def all_passed(metrics: Iterable[Metric]) -> bool:
    """Return whether no metric missed its bound."""
    return all(metric.passed is not False for metric in metrics)
