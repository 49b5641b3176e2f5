"""The figure of a frequency response: what became of sines that were asked for, one by one."""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from rig.report.data import RunData
from rig.report.figure import panels
from rig.report.style import GREY, INK, PAGE, PALETTE, new_figure, place_legend

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Complex = NDArray[np.complex128]

_TONE: Final = re.compile(r"([\d.]+(?:e-?\d+)?) Hz")
"""A segment in which the reference is a sine has its frequency for a name."""
_LEAST: Final = 2
"""Sines of which a response is drawn: one alone is a number."""
_BEYOND: Final = 2.0
"""How far the linear loop is drawn beyond the frequencies that were run."""
_AT_ONCE: Final = 1 << 18
"""Samples that are fitted together: what they take of memory does not grow with the run."""
_MARKERS: Final = "osD^v"

Linear = Callable[["NDArray[np.float64]"], "Complex"]
"""Takes frequencies in Hz; returns the response of a linear model."""


class Tone(NamedTuple):
    """The answer to one sine.

    Parameters
    ----------
    frequency : float
        Hz.
    response : complex
        Reading over reference at that frequency.
    """

    frequency: float
    response: complex


def tones_of(run: RunData, reference: str, reading: str) -> list[Tone]:
    """Return the response of one quantity in each segment that is a sine.

    Parameters
    ----------
    run : RunData
        The run.
    reference, reading : str
        Columns of the log.
    """
    found = []
    for segment in run.segments:
        named = _TONE.fullmatch(segment.name)
        if named is None:
            continue
        frequency = float(named[1])
        t = run.time
        periods = int((min(segment.end, float(t[-1])) - segment.start) * frequency + 1e-6)
        part = (t >= segment.start) & (t < segment.start + periods / frequency)
        if periods < 1 or np.count_nonzero(part) < 8:  # it was broken off
            continue
        asked = phasor(t[part], run.trace(reference)[part], frequency)
        if abs(asked) > 0.0:
            came = phasor(t[part], run.trace(reading)[part], frequency)
            found.append(Tone(frequency, came / asked))
    return found


def phasor(t: "NDArray[np.float64]", x: "NDArray[np.float64]", frequency: float) -> complex:
    """Return amplitude and phase of a signal's part at a frequency, by least squares."""
    angle = 2.0 * np.pi * frequency * t
    basis = np.column_stack([np.cos(angle), np.sin(angle), np.ones_like(t)])
    if len(x) > _AT_ONCE:  # the triangle that a piece has says the same of it in four rows
        pieces = (slice(k, k + _AT_ONCE) for k in range(0, len(x), _AT_ONCE))
        triangles = [np.linalg.qr(np.column_stack([basis[p], x[p]]), "r") for p in pieces]
        *sides, x = np.concatenate(triangles).T
        basis = np.column_stack(sides)
    (a, b, _), *_ = np.linalg.lstsq(basis, x, rcond=None)
    return complex(a, -b)


def draw_response(
    run: RunData, columns: Mapping[str, tuple[str, str]], linear: Linear | None = None
) -> "Figure | None":
    """Draw gain and phase over frequency, of each quantity; None: there are no two sines.

    Parameters
    ----------
    run : RunData
        The run.
    columns : mapping of str to (str, str)
        What to call a quantity, and the columns of its reference and its reading.
    linear : callable, optional
        What a linear model of the loop says.
    """
    tones: dict[str, Sequence[Tone]] = {}
    for name, both in columns.items():
        if run.has(*both):
            tones[name] = tones_of(run, *both)
    tones = {name: found for name, found in tones.items() if len(found) >= _LEAST}
    if not tones:
        return None
    figure = new_figure(PAGE, 62.0)
    gain, phase = panels(figure, 1, 2)
    ran = np.array([tone.frequency for found in tones.values() for tone in found])
    low, high = ran.min() / _BEYOND, ran.max() * _BEYOND
    gain.axhline(1.0, color=GREY, lw=0.5)
    phase.axhline(0.0, color=GREY, lw=0.5)
    if linear is not None:
        f = np.geomspace(low, high, 200)
        response = linear(f)
        gain.plot(f, np.abs(response), color=INK, lw=0.8, ls=(0, (4, 2)), label="linear loop")
        phase.plot(f, np.degrees(np.unwrap(np.angle(response))), color=INK, lw=0.8,
                   ls=(0, (4, 2)), label="linear loop")  # fmt: skip
    for (name, found), color, marker in zip(tones.items(), PALETTE, _MARKERS, strict=False):
        f = np.array([tone.frequency for tone in found])
        came = np.array([tone.response for tone in found])
        for axes, values in ((gain, np.abs(came)), (phase, np.degrees(np.angle(came)))):
            axes.plot(f, values, marker, ls=":", color=color, ms=4.0, lw=0.5, label=name)
    for axes, label in ((gain, "gain, reading over reference (1)"), (phase, "phase (deg)")):
        axes.set_xscale("log")
        axes.set_xlim(low, high)
        axes.set_xticks(np.unique(ran), labels=[f"{f:g}" for f in np.unique(ran)])
        axes.minorticks_off()
        axes.margins(y=0.12)
        axes.set_xlabel("frequency (Hz)")
        axes.set_ylabel(label)
    place_legend(gain, 4)
    return figure
