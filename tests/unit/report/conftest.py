"""Run folders with invented but plausible numbers, written by the real recorder."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from rig.experiment.metrics import RecordedSpec, evaluate, evaluation_as_json
from rig.hal.columns import Column
from rig.hal.motion import Segment
from rig.report.timing import summarise_timing
from rig.run_facts import EVALUATION, RunStatus
from rig.run_folder import RunFolder
from rig.runtime.log import read_log
from rig.runtime.recorder import LogRecorder

PERIOD = 0.002
_UNITS = {
    "phase": "", "reference.time": "s",
    "reading.position": "m", "reading.position_agonist": "m", "reading.position_antagonist": "m",
    "reading.pressure_agonist": "Pa", "reading.pressure_antagonist": "Pa",
    "reference.position": "m", "reference.velocity": "m/s",
    "applied.agonist": "Pa", "applied.antagonist": "Pa",
    "timing.lateness": "s", "timing.slack": "s", "timing.receive": "s", "timing.read": "s",
    "timing.control": "s", "timing.transmit": "s", "timing.record": "s",
}  # fmt: skip
COLUMNS = tuple(Column(name, unit, f"{name} of the test") for name, unit in _UNITS.items())

MakeRun = Callable[..., Path]


def sine_rows(duration: float, error: float) -> "tuple[np.ndarray, tuple[Segment, ...]]":
    """A sine of three frequencies after a second of approach."""
    random = np.random.default_rng(1)
    t = np.arange(-1.0, duration, PERIOD)
    frequency = np.where(t < duration * 0.5, 0.1, np.where(t < duration * 0.8, 0.2, 0.5))
    phase = 2 * np.pi * np.cumsum(np.where(t >= 0, frequency, 0.0)) * PERIOD
    reference = 4e-3 * (1 - np.cos(phase))
    velocity = np.gradient(reference, t)
    stick = error * np.tanh(velocity / 1e-3) * (1 + 0.4 * np.sin(9 * phase))
    position = reference - stick - 4e-3 * np.maximum(-t, 0.0) + 1e-6 * random.normal(size=len(t))
    difference = 3e4 * np.tanh(velocity / 5e-4) + 2e6 * velocity
    stages = random.lognormal(np.log([8e-6, 5e-6, 20e-6, 9e-6, 4e-6]), 0.25, (len(t), 5))
    stages[len(t) // 2, 3] = 2.5e-3
    lateness = np.abs(random.normal(0, 20e-6, len(t)))
    rows = np.column_stack([
        np.where(t >= 0, 1.0, 0.0), t, position, 0.03 - position, 0.03 + position,
        1.2e5 + difference / 2 + 200 * random.normal(size=len(t)),
        1.2e5 - difference / 2 + 200 * random.normal(size=len(t)),
        reference, velocity, 1.2e5 + difference / 2, 1.2e5 - difference / 2,
        lateness, PERIOD - stages.sum(axis=1), stages,
    ])  # fmt: skip
    bounds = (0.0, 0.5, 0.8, 1.0)
    segments = tuple(
        Segment(f"{f:g} Hz", (a + 0.02) * duration, (b - 0.01) * duration)
        for f, a, b in zip((0.1, 0.2, 0.5), bounds, bounds[1:], strict=False)
    )
    return rows, segments


@pytest.fixture
def make_run(tmp_path: Path) -> MakeRun:
    def make(
        name: str = "sine",
        *,
        duration: float = 10.0,
        error: float = 1e-4,
        status: RunStatus | None = RunStatus.OK,
        bound: float = 1.5e-4,
    ) -> Path:
        folder = RunFolder.create(
            tmp_path / "runs",
            f"cylinder-{name}",
            "virtual",
            inputs={
                "profile.yaml": "name: cylinder\n",
                "experiment.yaml": f"name: {name}\ncontroller: {name}\n",
            },
            seed=7,
            command=["rig", "run", f"cylinder-{name}", "--set", "a.b=<c>"],
            now=datetime(2026, 11, 21, 3, 45, 12, tzinfo=UTC),
        )
        rows, segments = sine_rows(duration, error)
        recorder = LogRecorder(folder.log_path, COLUMNS, 1_795_000_000_000_000_000)
        for k, row in enumerate(rows.tolist()):
            recorder.write(k, k * PERIOD, row)
        folder.record_event(0.0, "state", "idle → running")
        folder.record_event(3.2, "limit", "rate of <agonist> & antagonist limited", count=3)
        specs = {
            "tracking_rms": RecordedSpec(None, "0.2 Hz", max=bound),
            "tracking_max": RecordedSpec(None, "*", max=3e-4),
            "velocity_ripple": RecordedSpec(None),
            "pressure_max": RecordedSpec(None, max=4.5e5),
        }
        folder.write_json(EVALUATION, evaluation_as_json(segments, specs))
        if status is None:  # as a killed process leaves it
            import os

            os.close(recorder._fd)
            assert folder._events_fd is not None
            os.close(folder._events_fd)
            return folder.path
        recorder.close()
        log = read_log(folder.log_path)
        folder.write_metrics(evaluate(log, segments, specs))
        folder.write_timing(summarise_timing(log))
        folder.finish(status, 0 if status is RunStatus.OK else 1)
        return folder.path

    return make
