"""The page of a calibration: for each thing that was fitted its data, fit, residuals, before."""

from collections.abc import Sequence
from pathlib import Path

from rig.calibration.procedure import Finding
from rig.report.style import (
    BLUE,
    GREY,
    INK,
    PAGE,
    VERMILION,
    new_figure,
    paper_style,
    place_legend,
    save,
)

_ROW = 42.0
"""Height of a row, mm."""


def draw_page(folder: Path, name: str, findings: Sequence[Finding], origin: str) -> list[Path]:
    """Draw one row per panel: data with the old and the new fit, and what the fit leaves.

    At its edge stands the `origin` of what was measured.

    Returns
    -------
    list of Path
        The files.
    """
    panels = [panel for finding in findings for panel in finding.panels]
    with paper_style():
        figure = new_figure(PAGE, 12.0 + _ROW * len(panels))
        rows = figure.subplots(len(panels), 2, squeeze=False)
        for number, (panel, (data, rest)) in enumerate(zip(panels, rows, strict=True)):
            order = panel.x.argsort(kind="stable")
            x = panel.x[order]
            style = {"marker": ".", "ms": 2.5, "rasterized": len(x) > 2000}
            curve = panel.curve or (x, panel.before[order])
            data.plot(*curve, color=GREY, lw=0.8, ls=(0, (4, 2)), label="before")
            data.plot(x, panel.y[order], color=BLUE, lw=0, label="measured", **style)
            data.plot(
                x, panel.fit[order], color=VERMILION, lw=0, label="fit", **{**style, "ms": 1.5}
            )
            rest.set_title(panel.title, loc="left", fontsize=8.0)
            data.set_xlabel(panel.x_label)
            data.set_ylabel(panel.y_label)
            rest.axhline(0.0, color=INK, lw=0.5)
            left = panel.residual_scale * (panel.y - panel.fit)
            rest.plot(x, left[order], color=BLUE, lw=0, **style)
            rest.set_xlabel(panel.x_label)
            rest.set_ylabel(panel.residual_label)
            if number == 0:
                place_legend(data, 3)
        return save(figure, folder, name, origin)
