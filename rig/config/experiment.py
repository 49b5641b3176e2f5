"""Load an experiment and the options over it."""

import contextlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from typing import Annotated, Final, get_type_hints

from annotated_types import Interval, Unit

from rig.config.code_sections import Sections
from rig.config.diagnostics import Problems, nearest, shown
from rig.config.document import (
    Override,
    apply_overrides,
    load_document,
    parse_overrides,
    with_plain_quantities,
)
from rig.config.law_hint import hint_of_law
from rig.config.located import Node, places_of
from rig.config.models import Experiment, MetricSpec, ReferenceEntry
from rig.config.named_files import beside, check_files, with_path_beside
from rig.config.named_settings import Registry, controller_names
from rig.config.names import alone_in, find_file, is_name, is_path, list_files
from rig.config.profile import load_profile
from rig.config.settings import build
from rig.hal import ConfigurationError
from rig.hal.files import is_file

EXPERIMENT_KEYS: Final = (
    "extends", "name", "description", "rig", "controller", "reference", "approach", "metrics",
    "figures", "law",
)  # fmt: skip
"""Top-level keys of an experiment."""
_OWN: Final = ("figures", "reference")
"""Those of them that the rules of a plan name."""


@dataclass(frozen=True, slots=True)
class ExperimentHead:
    """The part of an experiment that is the same for every reference.

    Parameters
    ----------
    rig : str
        The profile's name, or the path of its file from this one on.
    controller : str
        The controller that drives it; an arm's or a walker's is a `law`, and may be called so.
    name : str
        Default: the name of the file.
    description : str
        One sentence for people.
    approach : float
        Time to go from where the rig is to where the reference starts, s.
    figures : tuple of str
        Names of the figures to draw.
    """

    rig: str
    controller: str
    name: str = ""
    description: str = ""
    approach: Annotated[float, Unit("s"), Interval(gt=0, le=600)] = 2.0
    figures: tuple[str, ...] = ()


def load_experiment(
    source: str | Path,
    registry: Registry,
    overrides: Sequence[str] = (),
    search: Sequence[Path] = (),
) -> Experiment:
    """Load an experiment, its bases and the options over it.

    Parameters
    ----------
    source : str or Path
        An experiment's name, or the path of a file.
    registry : Registry
        The names of controllers and references.
    overrides : sequence of str
        ``a.b=c`` options.
    search : sequence of Path
        The configuration folders, as `find_configs` returns them.

    Returns
    -------
    Experiment
        Valid as a whole, in SI; whether there is such a rig shows when its profile is loaded.

    Raises
    ------
    ProfileError
        With every error, located.
    ConfigurationError
        There is no such experiment, or a file cannot be read.
    """
    path = find_file(source, "experiments", search)
    problems = Problems()
    document = load_document(path, "experiments", search, problems)
    options = [
        option._replace(keys=("controller",)) if option.keys == ("law",) else option
        for option in parse_overrides(overrides, problems)
    ]
    root = apply_overrides(_with_controller(document.root, problems), options, problems)
    root = _with_rig_beside(root)
    _admit_rig(root, registry, search)
    sections = Sections(root, EXPERIMENT_KEYS, registry, problems)
    reference_node = sections.take("reference", required=True)
    reference = (
        None if reference_node is None else sections.chosen("reference", reference_node, "kind")
    )
    if reference is not None and reference_node is not None:
        check_files(reference[1], reference_node, "reference", problems)
    metrics = {
        name: _metric(node, problems)
        for name, node in sections.named("metrics", names=False).items()
    }
    head = sections.rest(ExperimentHead)
    _check_names(root, registry, problems, search)
    problems.raise_if_any()
    assert head is not None and reference is not None
    return Experiment(
        name=head.name or path.stem,
        description=head.description,
        rig=head.rig,
        controller=head.controller,
        reference=ReferenceEntry(*reference),
        approach=head.approach,
        metrics={name: spec for name, spec in metrics.items() if spec is not None},
        figures=head.figures,
        files=document.files,
        places=_places(root, options),
        unitless=_unitless(reference_node, reference[1]),
    )


def _admit_rig(root: Node, registry: Registry, search: Sequence[Path]) -> None:
    """Let take part what the experiment's rig names, if it names a law or path that is not ours."""
    reference = root.descend(("reference", "kind"))[0].value
    law = root.descend(("controller",))[0].value
    rig = root.descend(("rig",))[0].value
    known = reference in registry.names("reference") and law in controller_names(registry)
    if isinstance(rig, str) and not known:
        with contextlib.suppress(ConfigurationError):  # said when the profile itself is loaded
            load_profile(rig, registry, search=search)


def rig_of(source: str | Path, search: Sequence[Path] = ()) -> str | None:
    """Return the rig that an experiment's file names, however wrong the rest of it is."""
    try:
        root = load_document(
            find_file(source, "experiments", search), "experiments", search, Problems()
        ).root
    except ConfigurationError:
        return None
    named = with_path_beside(root.get("rig"))
    return named.value if named is not None and isinstance(named.value, str) else None


def _with_rig_beside(root: Node) -> Node:
    """Return the document with the path of its rig, if it names it by one, as one from here."""
    named = with_path_beside(root.get("rig"))
    if named is None or not isinstance(root.value, dict):
        return root
    return root.with_items({**root.value, "rig": named})


def _with_controller(root: Node, problems: Problems) -> Node:
    """Return the document with its law, if it names one, as its controller."""
    law = root.get("law")
    if law is None or not isinstance(root.value, dict):
        return root
    if "controller" in root.value:
        problems.add(law.heading, "law and controller name the same thing", "leave out one")
    items = {("controller" if key == "law" else key): node for key, node in root.value.items()}
    return root.with_items(items)


def _controllers_of(rig: str, registry: Registry, search: Sequence[Path]) -> Iterable[str]:
    """Return the controllers that a rig has; all that there are, if it cannot be read."""
    try:
        return load_profile(rig, registry, search=search).controllers
    except ConfigurationError:
        return controller_names(registry)


def _metric(node: Node, problems: Problems) -> MetricSpec | None:
    return build(MetricSpec, with_plain_quantities(node, ("max", "min"), problems), problems)


def _places(root: Node, options: Iterable[Override]) -> dict[str, str]:
    """Return where each key stands; of the file's own keys those that messages call by name."""
    places = dict(places_of(root))
    for key in {*places, *_OWN}:
        own = (o.node.key.told for o in options if o.keys[0] == key and o.node.key is not None)
        changed = ", ".join(dict.fromkeys(own))
        if changed and key in places and places[key] not in changed:
            places[key] = f"{changed}; over {places[key]}"
    return places | {f"experiment.{key}": places[key] for key in _OWN if key in places}


def _unitless(node: Node | None, settings: object) -> tuple[str, ...]:
    """Return a sentence for each quantity of a reference that is written without its unit."""
    if node is None or not isinstance(node.value, dict) or not is_dataclass(settings):
        return ()
    found = []
    hints = get_type_hints(type(settings), include_extras=True)
    for key, given in node.value.items():
        unit = next((m.unit for m in getattr(hints.get(key), "__metadata__", ())
                     if isinstance(m, Unit)), "")  # fmt: skip
        plain = isinstance(given.value, int | float) and not isinstance(given.value, bool)
        if unit and plain and given.value:
            number = f"{given.value:g}"
            found.append(f"reference.{key}: {number} has no unit and is read as {number} {unit}")
    return tuple(found)


def _file_of(rig: str, place: Node) -> str | None:
    """Return how the file of a rig is named that lies beside the file that says its name, if so."""
    file = beside(place) / f"{rig}.yaml"
    if not is_file(file):
        return None
    option = place.mark.source.option
    return f"did you mean the file {file}?" if option else f"for {file} write rig: {file.name}"


def _check_names(
    root: Node, registry: Registry, problems: Problems, search: Sequence[Path]
) -> None:
    """Note names that nothing has, also beside other errors."""
    rig, controller = (_text_under(key, root) for key in ("rig", "controller"))
    rigs = list_files("rigs", search) if search and not is_path(rig or "/") else {rig: None}
    if rig is not None and rig not in rigs:
        place, _ = root.descend(("rig",))
        hint = (
            _file_of(rig, place)
            or alone_in(rig, "rigs", search)
            or nearest(rig, [name for name in rigs if name is not None])
        )
        problems.add(place.mark, f"no rig is called {shown(rig)}", hint)
    if controller is not None and controller not in controller_names(registry):
        place, _ = root.descend(("controller",))
        of = controller_names(registry) if rig is None else _controllers_of(rig, registry, search)
        message = f"no controller is called {shown(controller)}"
        problems.add(place.mark, message, hint_of_law(controller, rig, of, registry, search))
    name = _text_under("name", root)
    if name and not is_name(name):
        place, _ = root.descend(("name",))
        problems.add(place.mark, f"name is {shown(name)}, expected one that a folder may have")


def _text_under(key: str, root: Node) -> str | None:
    node = root.get(key)
    return node.value if node is not None and isinstance(node.value, str) else None
