"""Metrics against closed forms, and their refusal to judge what is not there."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rig.experiment.measure import Measure, local_slope
from rig.experiment.metrics import (
    all_passed,
    evaluate,
    evaluation_as_json,
    evaluation_from_json,
)
from rig.experiment.windows import MetricError
from rig.hal import ContractBroken
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.runtime.log import Log

PERIOD = 0.002


def make_log(
    reference: Any, position: Any, duration: float = 4.0, pressures: bool = True, **fixed: Any
) -> Log:
    """A log with one second of approach before the reference, full of large errors."""
    t = np.arange(-1.0, duration, PERIOD)
    run = t >= -1e-9
    desired = np.where(run, reference(t), 0.0)
    columns = {
        "phase": np.where(run, 1.0, 0.0),
        "reference.time": t,
        "reference.position": desired,
        "reference.velocity": np.gradient(desired, t),
        "reading.position": np.where(run, position(t), 99.0),
        "reading.pressure_agonist": np.full_like(t, 1.2e5),
        "reading.pressure_antagonist": np.full_like(t, 0.8e5),
    }
    columns.update({name: fixed[name](t) for name in fixed})
    if not pressures:
        columns = {k: v for k, v in columns.items() if "pressure" not in k}
    values = np.column_stack(list(columns.values()))
    zeros = np.zeros(len(t), np.uint64)
    return Log(tuple(Column(n, "", "") for n in columns), zeros, t, values, zeros, True)


def spec(measure: str | None = None, segments: str = "*", **bounds: float) -> Any:
    return SimpleNamespace(
        measure=measure, segments=segments, max=bounds.get("max"), min=bounds.get("min")
    )


def value(log: Log, measure: str, *segments: Segment) -> float:
    return evaluate(log, segments or (Segment("all", 0.0, 4.0),), {measure: spec()})[0].value


def sine(t: Any) -> Any:
    return 5e-3 * np.sin(2 * np.pi * t)


def test_errors_of_a_known_sine() -> None:
    log = make_log(sine, lambda t: sine(t) - 1e-4 * np.sin(2 * np.pi * 3 * t))
    assert value(log, "tracking_rms") == pytest.approx(1e-4 / math.sqrt(2), rel=1e-3)
    assert value(log, "tracking_max") == pytest.approx(1e-4, rel=1e-3)
    assert value(log, "hold_rms") == value(log, "tracking_rms")


def test_segments_are_pooled_for_rms_and_compared_for_maxima() -> None:
    log = make_log(np.zeros_like, lambda t: np.where(t < 2.0, 1e-3, 2e-3))
    halves = (Segment("a", 0.0, 2.0), Segment("b", 2.0, 4.0))
    assert value(log, "tracking_rms", *halves) == pytest.approx(math.sqrt(2.5) * 1e-3)
    assert value(log, "tracking_max", *halves) == pytest.approx(2e-3)
    assert value(log, "hunting", *halves) == 0.0
    assert value(log, "hunting") == pytest.approx(1e-3)
    one = evaluate(log, halves, {"x": spec("tracking_rms", "b")})
    assert one[0].value == pytest.approx(2e-3)


def test_step_of_first_and_second_order() -> None:
    tau, size = 0.1, 5e-3
    log = make_log(lambda t: np.full_like(t, size), lambda t: size * (1 - np.exp(-t / tau)))
    assert value(log, "rise_time") == pytest.approx(tau * math.log(9), abs=2 * PERIOD)
    assert value(log, "settling_time") == pytest.approx(tau * math.log(50), abs=2 * PERIOD)
    assert value(log, "overshoot") == 0.0
    zeta, w = 0.4, 12.0
    damped = w * math.sqrt(1 - zeta**2)
    log = make_log(
        lambda t: np.full_like(t, -size),
        lambda t: (
            -size
            * (
                1
                - np.exp(-zeta * w * t)
                * (np.cos(damped * t) + zeta * w / damped * np.sin(damped * t))
            )
        ),
    )
    expected = math.exp(-zeta * math.pi / math.sqrt(1 - zeta**2))
    assert value(log, "overshoot") == pytest.approx(expected, rel=1e-2)


def test_step_that_never_arrives_is_infinite_and_fails() -> None:
    log = make_log(lambda t: np.full_like(t, 1e-3), lambda t: 4e-4 * np.minimum(t, 1.0))
    segments = (Segment("step", 0.0, 4.0),)
    for measure in ("rise_time", "settling_time"):
        (metric,) = evaluate(log, segments, {measure: spec(max=1.0)})
        assert metric.value == math.inf and metric.passed is False
        assert metric.as_json()["value"] is None


@pytest.mark.parametrize("measure", ["rise_time", "settling_time", "overshoot"])
def test_a_segment_that_is_no_step_has_no_step_response(measure: str) -> None:
    held = make_log(lambda t: np.where(t < 1.0, 2e-3, 4e-3), lambda t: np.full_like(t, 3.99e-3))
    moving = make_log(sine, sine)
    hold, whole = Segment("hold", 2.0, 3.0), Segment("all", 0.0, 4.0)
    for log, segment in ((held, hold), (moving, whole), (held, whole)):
        assert evaluate(log, (segment,), {measure: spec()}) == []
        with pytest.raises(MetricError, match=f"{measure}: no segment is a step"):
            evaluate(log, (segment,), {measure: spec(max=1.0)})
    # A run that holds from its first cycle on, off by what friction keeps it off.
    still = make_log(np.zeros_like, lambda t: np.full_like(t, -15e-6))
    assert evaluate(still, (whole,), {measure: spec()}) == []
    step = Segment("step", 1.0, 2.0)
    assert value(held, measure, hold, step) == value(held, measure, step)


def test_a_measure_that_ends_the_program_is_refused_with_its_name() -> None:
    def leave(windows: Any) -> float:
        raise SystemExit(5)

    log, whole = make_log(sine, sine), Segment("all", 0.0, 4.0)
    with pytest.raises(ContractBroken, match=r"the measure mine .*SystemExit: 5"):
        evaluate(log, (whole,), {"mine": spec()}, measures={"mine": Measure(leave, "", "mine")})


def test_velocity_measures_of_a_stick_slip_ramp() -> None:
    """Half of each 0.4 s it stands, half it moves at twice the speed."""
    speed = 2e-3

    def stick_slip(t: Any) -> Any:
        k, into = np.divmod(t, 0.4)
        return speed * (0.4 * k + 2.0 * np.maximum(into - 0.2, 0.0))

    log = make_log(lambda t: speed * t, stick_slip)
    assert value(log, "stick_share") == pytest.approx(0.5, abs=0.04)  # the slope blurs its ends
    assert value(log, "velocity_ripple") == pytest.approx(1.0, abs=0.05)
    smooth = make_log(lambda t: speed * t, lambda t: speed * t)
    assert value(smooth, "stick_share", Segment("late", 0.5, 4.0)) == 0.0
    assert value(smooth, "velocity_ripple", Segment("late", 0.5, 4.0)) < 1e-9


def test_pressures_and_breakaway() -> None:
    log = make_log(
        lambda t: 1e-3 * t,
        lambda t: 1e-3 * np.maximum(t - 1.0, 0.0),
        **{"reading.pressure_agonist": lambda t: 1.2e5 + 2e4 * t},
    )
    assert value(log, "pressure_max") == pytest.approx(2.0e5, rel=1e-3)
    assert value(log, "pressure_min") == 0.8e5
    assert value(log, "breakaway_pressure") == pytest.approx(2e4 * 1.02, rel=0.01)
    without = make_log(sine, sine, pressures=False)
    for measure in ("pressure_max", "pressure_min", "breakaway_pressure"):
        with pytest.raises(MetricError, match=f"{measure}: .*reading.pressure_"):
            value(without, measure)


def test_bounds() -> None:
    log = make_log(np.zeros_like, lambda t: np.full_like(t, 1e-3))
    segments = (Segment("hold +0 mm #1", 1.0, 2.0),)
    metrics = evaluate(
        log,
        segments,
        {
            "good": spec("hold_max", "hold*", max=1.1e-3),
            "bad": spec("hold_max", "hold*", max=0.9e-3),
            "free": spec("hold_max"),
            "floor": spec("hold_max", min=0.5e-3),
            "both": spec("hold_max", max=2e-3, min=1.5e-3),
        },
    )
    assert [(m.name, m.bound, m.bound_kind, m.passed) for m in metrics] == [
        ("good", 1.1e-3, "max", True),
        ("bad", 0.9e-3, "max", False),
        ("free", None, None, None),
        ("floor", 0.5e-3, "min", True),
        ("both", 2e-3, "max", True),
        ("both.min", 1.5e-3, "min", False),
    ]
    assert not all_passed(metrics) and all_passed(metrics[2:5])
    entry = metrics[1].as_json()
    assert (entry["name"], entry["unit"], entry["pass"]) == ("bad", "m", False)
    assert entry["bound"] == 0.9e-3 and entry["value"] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("segments", "specs", "message"),
    [
        ((), {"tracking_rms": spec()}, "no segment matches"),
        ((Segment("a", 0.0, 1.0),), {"tracking_rms": spec(segments="b*")}, "there are 'a'"),
        ((Segment("a", 0.0, 1.0),), {"fast": spec()}, "no measure is called 'fast'"),
        ((Segment("late", 3.0, 5.0),), {"tracking_rms": spec()}, "the log ends at 3.998 s"),
        ((Segment("never", 8.0, 9.0),), {"tracking_rms": spec()}, "'never' lasts from 8.000"),
    ],
)
def test_what_cannot_be_judged_is_an_error(segments: Any, specs: Any, message: str) -> None:
    with pytest.raises(MetricError, match=message):
        evaluate(make_log(sine, sine), segments, specs)


def test_run_that_never_followed_its_reference_is_an_error() -> None:
    log = make_log(sine, sine)
    approach = log._replace(values=log.values[log.t < -0.5], t=log.t[log.t < -0.5])
    with pytest.raises(MetricError, match="before the reference started"):
        value(approach, "tracking_rms")


def test_evaluation_survives_the_disk() -> None:
    segments = (Segment("0.2 Hz", 1.0, 2.0),)
    specs = {"tracking_rms": spec("tracking_rms", "0.2*", max=1e-4)}
    again, restored = evaluation_from_json(evaluation_as_json(segments, specs))
    assert again == segments
    assert restored["tracking_rms"].max == 1e-4 and restored["tracking_rms"].segments == "0.2*"


def test_slope_is_exact_on_lines_and_holds_over_missed_ticks() -> None:
    t = np.delete(np.arange(0.0, 1.0, PERIOD), [100, 101, 102, 300])
    assert np.allclose(local_slope(t, 3.0 * t + 1.0), 3.0, atol=1e-12)
    fast = np.sin(2 * np.pi * 20 * t)
    assert np.abs(local_slope(t, fast)).max() > 0.8 * 2 * np.pi * 20
    assert local_slope(t[:1], t[:1]).tolist() == [0.0]
