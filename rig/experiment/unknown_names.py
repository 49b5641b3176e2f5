"""The measures and figures of an experiment that its mechanism has not, however wrong the rest."""

from collections.abc import Sequence
from pathlib import Path

from rig.assembly import REGISTRY
from rig.config.diagnostics import Diagnostic, Problems, nearest, shown
from rig.config.document import apply_overrides, load_document, parse_overrides
from rig.config.located import Node
from rig.config.names import find_file
from rig.experiment.metrics import known_measures


def unknown_names(
    source: str | Path, options: Sequence[str], search: Sequence[Path], mechanism: str
) -> tuple[Diagnostic, ...]:
    """Return where an experiment names a measure or a figure that there is not.

    Parameters
    ----------
    source : str or Path
        Its name or file.
    options : sequence of str
        ``a.b=c`` options over it.
    search : sequence of Path
        The folders of configurations.
    mechanism : str
        Its rig's.
    """
    elsewhere, problems = Problems(), Problems()  # what else is wrong is said by who loads it
    file = find_file(source, "experiments", search)
    document = load_document(file, "experiments", search, elsewhere)
    root = apply_overrides(document.root, parse_overrides(options, elsewhere), elsewhere)
    _check_metrics(root.get("metrics"), mechanism, problems)
    _check_figures(root.get("figures"), mechanism, problems)
    return problems.error().diagnostics


def _check_metrics(metrics: Node | None, mechanism: str, problems: Problems) -> None:
    if metrics is None or not isinstance(metrics.value, dict):
        return
    known = (*known_measures(mechanism), *(name for name, _ in REGISTRY.facts(mechanism)))
    for name, spec in metrics.value.items():
        said = spec.get("measure") if isinstance(spec.value, dict) else None
        place = said.mark if said is not None else spec.heading
        measure = name if said is None else said.value
        if isinstance(measure, str) and measure not in known:
            problems.add(place, f"no measure is called {shown(measure)}", nearest(measure, known))


def _check_figures(figures: Node | None, mechanism: str, problems: Problems) -> None:
    from rig.report.figures import figure_kind, known_figures

    known = known_figures(mechanism)
    for node in figures.value if figures is not None and isinstance(figures.value, list) else ():
        name = node.value
        if isinstance(name, str) and figure_kind(name, known) is None:
            problems.add(node.mark, f"no figure is called {shown(name)}", nearest(name, known))
