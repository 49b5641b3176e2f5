"""How figures look: sized for a two-column paper, readable in print and by the colour-blind."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rig.experiment.segments import Segment

COLUMN = 85.0
PAGE = 170.0
"""Widths of one and of two columns, mm."""

BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9",
)  # fmt: skip
PALETTE = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
"""M. Okabe, K. Ito, *Color Universal Design*, 2008."""
INK = "#222222"
GREY = "#8a8a8a"
SHADE = "#eef2f6"

_RC = {
    # Fonts that come with matplotlib, so that a figure looks the same on every machine.
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 8.5,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#d9dde2",
    "grid.linewidth": 0.4,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.borderaxespad": 0.0,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 100,
    "savefig.dpi": 220,
    # The same data give the same file.
    "svg.hashsalt": "rig",
    "path.simplify_threshold": 0.1,
}

SEGMENT_TEXT = 7.0
"""Size of the labels of segments, pt."""


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw and save figures in the house style."""
    import matplotlib as mpl

    settings: Any = _RC  # matplotlib's stubs want each key as a literal
    with mpl.rc_context(settings):
        yield


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure of a size in mm, without touching any global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / 25.4, height / 25.4))


def save(figure: "Figure", folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG; return both paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{name}.png", folder / f"{name}.svg"]
    figure.savefig(paths[0])
    figure.savefig(paths[1], metadata={"Date": None})
    return paths


def place_legend(axes: "Axes", columns: int) -> None:
    """Put the legend above the axes, where it covers no data."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.01), ncols=columns, columnspacing=1.2)


def length_scale(extent: float) -> tuple[float, str]:
    """Return factor and unit in which lengths of this size (m) read best."""
    return (1e6, "µm") if extent < 0.1e-3 else (1e3, "mm")


def format_length(value: float) -> str:
    """Format a length in m with three digits, in mm or µm."""
    factor, unit = length_scale(abs(value))
    return f"{value * factor:.3g} {unit}"


def shade_segments(
    axes: "Axes", width: float, segments: "Sequence[Segment]", labels: Sequence[str]
) -> None:
    """Shade segments and label them at the top of the axes, where headroom is made for it.

    Parameters
    ----------
    axes : Axes
        With its data and x limits.
    width : float
        Of the figure, mm.
    segments, labels : sequences
        What to shade; a label's first line alone stands upright where both do not fit.
    """
    if not segments:
        return
    left, right = axes.get_xlim()
    # Axis labels and margins take about an eighth of a figure.
    scale = 0.87 * width / 25.4 * 72.0 / (right - left)
    character = 0.46 * SEGMENT_TEXT

    def fits(segment: "Segment", label: str) -> bool:
        longest = max(len(line) for line in label.split("\n"))
        return longest * character < (segment.end - segment.start) * scale

    level = all(fits(segment, label) for segment, label in zip(segments, labels, strict=True))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + (high - low) * (0.22 if level else 0.42))
    for segment, label in zip(segments, labels, strict=True):
        axes.axvspan(segment.start, segment.end, color=SHADE, lw=0, zorder=0)
        axes.text(
            0.5 * (segment.start + segment.end),
            0.975,
            label if level else label.split("\n", maxsplit=1)[0],
            transform=axes.get_xaxis_transform(),
            rotation=0 if level else 90,
            ha="center",
            va="top",
            fontsize=SEGMENT_TEXT,
            linespacing=1.2,
            color="#4a5560",
        )
