"""What the camera adds to the joint: how late it is, how much nearer it comes to the marker."""

from typing import TYPE_CHECKING

import numpy as np

from rig.experiment.measure import Samples, Window, local_slope
from rig.mechanisms.joint.measures.camera import (
    ENCODERS,
    TRUTH,
    camera_samples,
    stamp_error,
)
from rig.mechanisms.joint.measures.laps import lap_errors
from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    PAGE,
    PALETTE,
    VERMILION,
    new_figure,
    place_legend,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHIFTS = np.linspace(-15e-3, 15e-3, 121)
"""By which the stamps are shifted to see where camera and track agree best, s."""
_SOURCES = (("encoders", ENCODERS, BLUE), ("true marker", TRUTH, VERMILION))


def draw_camera(run: RunData) -> "Figure | None":
    """Draw the age of the samples, the latency that fits best, and what the fusion gains."""
    if not run.has("reading.marker_age", f"{ENCODERS}_x"):
        return None
    samples = Samples(run.log)
    windows = [window for window in _windows(run, samples) if _moves(window)]
    if not windows:
        return None
    figure = new_figure(PAGE, 60.0)
    age, fit, gain = figure.subplots(1, 3)
    ages = np.concatenate([camera_samples(window).age for window in windows]) * 1e3
    edges = np.arange(np.floor(ages.min()) - 1.0, np.ceil(ages.max()) + 1.5, 0.25)
    age.hist(ages, bins=edges, color=BLUE, lw=0)
    mean = float(ages.mean())
    age.axvline(mean, color=INK, lw=0.8, ls=(0, (4, 2)), label=f"mean {mean:.1f} ms")
    age.set_xlabel("age of a sample when used first (ms)")
    age.set_ylabel("samples")
    place_legend(age, 1)
    _draw_fit(fit, run, windows[-1])
    _draw_gain(gain, run, windows)
    return figure


def _draw_fit(axes: "Axes", run: RunData, window: Window) -> None:
    """Draw how well camera and track agree, over an error of the calibrated latency."""
    samples = camera_samples(window)
    inside = (samples.t > window.t[0] + _SHIFTS[-1]) & (samples.t < window.t[-1] - _SHIFTS[-1])
    for label, source, color in _SOURCES:
        if not run.has(f"{source}_x"):
            continue
        track = window.columns(f"{source}_")
        gaps = []
        for shift in _SHIFTS:
            t = samples.t[inside] - shift
            seen = np.column_stack([np.interp(t, window.t, track[:, k]) for k in range(3)])
            gap = samples.marker[inside] - seen
            gaps.append(float(np.sqrt(np.mean(np.sum((gap - gap.mean(axis=0)) ** 2, axis=1)))))
        found = stamp_error([window], source)
        axes.plot(_SHIFTS * 1e3, np.array(gaps) * 1e6, color=color)
        axes.plot([], [], color=color, label=f"{label}: {found * 1e3:+.2f} ms")
        axes.axvline(found * 1e3, color=color, lw=0.6, ls=(0, (4, 2)))
    axes.plot([], [], color=INK, lw=0.6, ls=(0, (4, 2)), label="estimate")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("latency beyond the calibrated (ms)")
    axes.set_title(window.segment.name, loc="left")
    axes.set_ylabel("camera off the track, rms (µm)")
    place_legend(axes, 1)


def _draw_gain(axes: "Axes", run: RunData, windows: list[Window]) -> None:
    """Draw how far from the true marker the encoders are, and the fused estimate."""
    if not run.has(f"{TRUTH}_x"):
        axes.set_axis_off()
        return
    for number, (label, source, color) in enumerate(
        (("encoders", ENCODERS, GREY), ("with camera", "estimate.marker", GREEN))
    ):
        errors = [
            np.linalg.norm(window.columns(f"{source}_") - window.columns(f"{TRUTH}_"), axis=1)
            for window in windows
        ]
        values = [float(np.sqrt(np.mean(error**2))) * 1e6 for error in errors]
        places = np.arange(len(windows)) + 0.36 * (number - 0.5)
        axes.bar(places, values, 0.34, color=color, label=label)
        for place, value in zip(places, values, strict=True):
            axes.annotate(f"{value:.0f}", (place, value), (0, 1.5), textcoords="offset points",
                          ha="center", fontsize=6.5)  # fmt: skip
    axes.set_xticks(range(len(windows)), labels=[window.segment.name for window in windows])
    axes.tick_params(axis="x", labelsize=6.5)
    axes.set_ylabel("off the true marker, rms (µm)")
    axes.grid(axis="x", visible=False)
    place_legend(axes, 2)


def draw_learning(run: RunData) -> "Figure | None":
    """Draw what each lap left of the errors, and where learning ended by itself."""
    if not run.has("estimate.lap", "reference.rod_ch1"):
        return None
    samples = Samples(run.log)
    windows = [w for w in _windows(run, samples) if len(w.t) and w.column("estimate.lap").max() > 0]
    if not any(w.column("estimate.learning").max() > 0.0 for w in windows):  # nobody learns
        return None
    figure = new_figure(PAGE, 62.0)
    wires, marker = figure.subplots(1, 2)
    has_ended = False
    for window, color in zip(windows, PALETTE, strict=False):
        errors = lap_errors(window)
        laps = np.arange(1, len(errors.wires) + 1)
        has_ended = has_ended or errors.ended is not None
        for axes, values in ((wires, errors.wires), (marker, errors.marker)):
            axes.plot(laps, values * 1e6, "-o", ms=3.0, color=color, label=window.segment.name)
            if errors.ended is not None:
                axes.axvline(errors.ended + 0.5, color=color, lw=0.8, ls=(0, (4, 2)))
    if has_ended:
        marker.plot([], [], color=INK, lw=0.8, ls=(0, (4, 2)), label="nothing more learnt")
    for axes, label in ((wires, "wire pairs, rms (µm)"), (marker, "marker, rms (µm)")):
        axes.set_xlabel("lap")
        axes.set_ylabel(label)
        axes.set_ylim(bottom=0.0)
        axes.xaxis.get_major_locator().set_params(integer=True)
    place_legend(marker, 4)
    return figure


def _windows(run: RunData, samples: Samples) -> list[Window]:
    """Return those of the segments at one speed that the run got through."""
    windows = []
    for segment in run.segments:
        done = len(samples.t) > 0 and samples.t[-1] >= segment.end - 2.0 * samples.period
        if done and segment.name.endswith("Hz"):
            first, last = np.searchsorted(samples.t, [segment.start, segment.end])
            windows.append(Window(segment, samples, slice(int(first), int(last))))
    return windows


def _moves(window: Window) -> bool:
    """Return whether the camera saw the marker move."""
    try:
        camera_samples(window)
    except ValueError:
        return False
    return bool(np.any(local_slope(window.t, window.column(f"{ENCODERS}_x"))))


CAMERA_FIGURES = {
    "camera": FigureKind(
        draw_camera,
        "Age of the camera's samples; error of the calibrated latency, where camera and track "
        "agree best; how far the marker's estimate is from the true one.",
    ),
    "learning": FigureKind(draw_learning, "What each lap left of the errors."),
}
