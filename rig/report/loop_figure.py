"""The figure of a measured loop: gain, phase and sensitivity over frequency, beside a model."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from rig.hal.closed_loop import SENSITIVITY
from rig.hal.measured_loop import MeasuredLoop
from rig.report.figure import panels
from rig.report.style import BLUE, GREY, INK, PAGE, VERMILION, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

_COLORS: Final = (BLUE, GREY)
_GAINS: Final = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20)
_BEYOND: Final = 1.2
_TICKS: Final = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)


def draw_loops(loops: Mapping[str, MeasuredLoop]) -> "Figure":
    """Draw loops, those in force first: measured with 95 % of what glides differ by, and modelled.

    Parameters
    ----------
    loops : mapping of str to MeasuredLoop
        By what to call them; one, or now and before.
    """
    figure = new_figure(PAGE, 62.0)
    gain, phase, sensitivity = panels(figure, 1, 3)
    for (name, loop), color in zip(loops.items(), _COLORS, strict=False):
        f = loop.frequencies
        _line(gain, f, np.abs(loop.response), np.abs(loop.drawn), np.abs(loop.model), color, name)
        turned = _phase(loop.response)
        drawn = turned + np.degrees(np.angle(loop.drawn / loop.response))
        _line(phase, f, turned, drawn, _phase(loop.model), color, name)
        _line(sensitivity, f, _sensitivity(loop.response), _sensitivity(loop.drawn),
              _sensitivity(loop.model), color, name)  # fmt: skip
    gain.axhline(1.0, color=GREY, lw=0.5)
    gain.set_yscale("log")
    low, high = gain.get_ylim()
    gains = [tick for tick in _GAINS if low <= tick <= high]
    gain.set_yticks(gains, labels=[f"{tick:g}" for tick in gains])
    gain.minorticks_off()
    phase.axhline(-180.0, color=GREY, lw=0.5)
    sensitivity.axhline(SENSITIVITY, color=VERMILION, lw=0.8, ls=":")
    labels = (
        "gain of the open loop (1)",
        "phase (deg)",
        f"sensitivity (1), at most {SENSITIVITY:g}",
    )
    measured = np.concatenate([loop.frequencies for loop in loops.values()])
    low, high = measured.min() / _BEYOND, measured.max() * _BEYOND
    for axes, label in zip((gain, phase, sensitivity), labels, strict=True):
        axes.set_xscale("log")
        axes.set_xlim(low, high)
        ticks = [tick for tick in _TICKS if low <= tick <= high]
        axes.set_xticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        axes.set_xlabel("frequency (Hz)")
        axes.set_ylabel(label)
    place_legend(gain, 2)
    return figure


def _line(
    axes: "Axes",
    f: "Array",
    measured: "Array",
    drawn: "Array",
    model: "Array",
    color: str,
    name: str,
) -> None:
    low, high = np.percentile(drawn, (2.5, 97.5), axis=0)
    axes.fill_between(f, low, high, color=color, alpha=0.25, lw=0)
    axes.plot(f, measured, "o-", color=color, ms=2.5, lw=0.8, label=name)
    ink = INK if color == BLUE else color
    axes.plot(f, model, color=ink, lw=0.8, ls=(0, (4, 2)), label=f"{name}, model")


def _phase(response: "NDArray[np.complex128]") -> "Array":
    """Return the phase, deg, without jumps, and between -360 and 0 where it begins."""
    turned = np.degrees(np.unwrap(np.angle(response)))
    return np.asarray(turned - 360.0 * np.ceil(turned[0] / 360.0))


def _sensitivity(response: "NDArray[np.complex128]") -> "Array":
    return np.asarray(1.0 / np.abs(1.0 + response))
