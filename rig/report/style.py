"""The style of figures: sized for a two-column paper, readable in print and by the colour-blind."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rig.hal.files import reason_unwritten
from rig.report.figure_data import table_of
from rig.run_folder import RunFolderError
from rig.whole_file import refuse_link, whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

    from rig.hal.motion import Segment

COLUMN = 85.0
PAGE = 170.0
"""Widths of one and of two columns, mm."""

BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9",
)  # fmt: skip
PALETTE = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
"""M. Okabe, K. Ito, *Color Universal Design*, 2008."""
PALE = "#f0b9a0"
"""Of what is commanded, below what came of it: setpoints may swing from rail to rail."""
INK = "#222222"
GREY = "#8a8a8a"
SHADE = "#eef2f6"
BAND = "#dfe5ec"
"""Of what is named in the legend; segments are lighter, and named where they are."""

_RC: "dict[RcKeyType, object]" = {
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
ORIGIN_TEXT = 4.5
"""Size of where the data come from, pt."""


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw and save figures in the house style."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure of a size in mm, without touching any global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width / 25.4, height / 25.4))


def save(
    figure: "Figure",
    folder: Path,
    name: str,
    origin: str,
    *,
    has_table: bool = False,
    content: Iterable[str] | None = None,
) -> list[Path]:
    """Write a figure as PNG, SVG and PDF, and what it shows as CSV; return the paths.

    Parameters
    ----------
    figure : Figure
        Drawn.
    folder : Path
        Where the files go.
    name : str
        Theirs, without suffix.
    origin : str
        Where its data come from, written at its edge: a figure is passed on without its folder.
    has_table : bool
        The folder has a table of that name already, which the figure is drawn from.
    content : iterable of str, optional
        Of the table, in pieces; default: the figure's lines.

    Raises
    ------
    RunFolderError
        They cannot be written.
    """
    paths = [folder / f"{name}.{kind}" for kind in ("png", "svg", "pdf", "csv")]
    picture, svg, pdf, table = paths
    try:
        refuse_link(folder)
        folder.mkdir(parents=True, exist_ok=True)
        _leave_room(figure)
        figure.text(
            1.0, 0.0, origin, ha="right", va="bottom", fontsize=ORIGIN_TEXT, color="#4a5560"
        )
        with whole_file(picture) as temporary:
            figure.savefig(temporary)
        with _kept_layout(figure):
            for path, date in ((svg, "Date"), (pdf, "CreationDate")):
                with whole_file(path) as temporary:
                    figure.savefig(temporary, metadata={date: None})
        if not has_table:
            with whole_file(table) as temporary:
                told = (table_of(figure),) if content is None else content
                with temporary.open("w", encoding="utf-8") as stream:
                    stream.writelines(told)
    except OSError as error:
        raise RunFolderError(
            f"cannot write figures to {folder}: {reason_unwritten(folder, error)}"
        ) from error
    return paths


def _leave_room(figure: "Figure") -> None:
    """Keep the drawing off the line at its foot, which says where it comes from."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        foot = 1.5 * ORIGIN_TEXT / 72.0 / figure.get_figheight()
        engine.set(rect=(0.0, foot, 1.0, 1.0 - foot))


@contextmanager
def _kept_layout(figure: "Figure") -> Iterator[None]:
    """Save with the layout that the figure has; an engine, even an idle one, draws it once more."""
    import matplotlib as mpl

    with mpl.rc_context({"figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)
        yield


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
    axes: "Axes", width: float, segments: "Sequence[Segment]", notes: Sequence[str] = ()
) -> None:
    """Shade segments and label them at the top of the axes, where headroom is made for it.

    Parameters
    ----------
    axes : Axes
        With its data and x limits.
    width : float
        Of the figure, mm.
    segments : sequence of Segment
        What to shade.
    notes : sequence of str
        A second line for each label, shown where it fits.
    """
    left, right = axes.get_xlim()
    # A run that ended early never reached its last segments.
    notes = [note for segment, note in zip(segments, notes, strict=False) if segment.start < right]
    segments = [segment for segment in segments if segment.start < right]
    if not segments:
        return
    names = [segment_label(segment.name) for segment in segments]
    centres = [0.5 * (segment.start + min(segment.end, right)) for segment in segments]
    # Axis labels and margins take about an eighth of a figure.
    scale = 0.87 * width / 25.4 * 72.0 / (right - left)
    # A label may reach over the edge of its segment, but not into the next label.
    room = scale * min((b - a for a, b in pairwise(centres)), default=right - left)
    labels = [f"{name}\n{note}" for name, note in zip(names, notes, strict=False)] or names
    if _text_width(labels) > room:
        labels = names
    level = _text_width(labels) < room
    figure = axes.get_figure(root=True)
    assert figure is not None  # axes of a live figure always have one
    height = axes.get_position().height * figure.get_figheight() * 72.0
    lines = max(label.count("\n") for label in labels) + 1
    needed = 4.0 + (1.3 * SEGMENT_TEXT * lines if level else _text_width(labels))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + (high - low) * needed / (height - needed))
    for segment, centre, label in zip(segments, centres, labels, strict=True):
        axes.axvspan(segment.start, segment.end, color=SHADE, lw=0, zorder=0)
        axes.annotate(
            label,
            (centre, 1.0),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0.0, -2.0),
            textcoords="offset points",
            rotation=0 if level else 90,
            ha="center",
            va="top",
            fontsize=SEGMENT_TEXT,
            linespacing=1.2,
            color="#4a5560",
        )


def segment_label(name: str) -> str:
    """Return a segment's name as it is printed: no number, and a proper minus sign."""
    return re.sub(r"-(?=\d)", "−", re.sub(r" #\d+$", "", name))


def _text_width(labels: Sequence[str]) -> float:
    """Estimate the width of the longest line, pt."""
    return 0.47 * SEGMENT_TEXT * max(len(line) for label in labels for line in label.split("\n"))
