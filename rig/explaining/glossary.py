"""Every name that a file or a report may hold, with its meaning, read off the code behind it."""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, cast

from rig.assembly import REGISTRY
from rig.config.experiment import ExperimentHead
from rig.config.heads import DeviceHead, ProfileHead
from rig.config.models import MetricSpec
from rig.config.named_settings import Kind
from rig.config.settings import adapter
from rig.experiment.measure import Measure
from rig.explaining.exit_codes import EXIT_CODES
from rig.hal.formats import format_quantity

Schema = Mapping[str, object]

PROFILE, EXPERIMENT = "profile key", "experiment key"
MEASURE, FACT = "measure", "planned measure"
SWEEP, SCENARIO = "sweep key", "fault scenario key"
LAW, FIGURE, EXIT_CODE = "control law", "figure", "exit code"
FAULT = "fault in simulation"
PARTS: Mapping[str, tuple[Kind, str]] = {
    "motion": ("reference", "reference.kind"),
    "driver": ("driver", "devices.NAME.driver"),
    "mechanism": ("mechanism", "mechanism"),
    "plant": ("plant", "plant.model"),
    "protocol": ("bus", "buses.NAME.protocol"),
}
"""Parts that files name, as people call them: their kind, and the key that names one."""


class Word(NamedTuple):
    """A name and its meaning.

    Parameters
    ----------
    name : str
        As files and reports have it, sections and keys joined by dots.
    kind : str
        What it is a name of.
    of : str
        The mechanism, driver, law or the like that has it; empty: all.
    text : str
        What it means.
    default : str
        What it is where a file does not say it; empty: it must be said, or there is none.
    """

    name: str
    kind: str
    of: str
    text: str
    default: str = ""


def glossary() -> tuple[Word, ...]:
    """Return every key of files, part, law, measure, figure and exit code."""
    from rig.faults.scenario_file import Scenario
    from rig.sweeping.sweep_keys import SweepKeys

    return (
        *_profile_keys(),
        *_experiment_keys(),
        *_keys(SWEEP, "", "", SweepKeys),
        *_keys(SCENARIO, "", "", Scenario),
        *_parts(),
        *without_keys(),
    )


def without_keys() -> tuple[Word, ...]:
    """Return the words that are no keys of files: those need the schemas of every part, 2 s."""
    return (*_laws(), *_measures(), *_facts(), *_figures(), *_faults(), *exit_codes())


def exit_codes() -> Iterator[Word]:
    """Return what the program's exit codes mean."""
    return (Word(code, EXIT_CODE, "", text) for code, text in EXIT_CODES.items())


def _faults() -> Iterator[Word]:
    """Return what ``rig faults list`` may name, on whichever rig."""
    from rig.faults.catalogue import KINDS
    from rig.faults.kind import either, ride
    from rig.faults.uncounted import is_excused, reason_of

    for name, kind in KINDS.items():
        is_sought = kind.must not in (either, ride)
        within = format_quantity(kind.within, "s")
        soon = f" Where it has to be seen: within {within}." if is_sought else ""
        unseen = f" Why it may go unseen: {kind.why}." if kind.why else ""
        excused = f" Not every hazard counts: {reason_of(kind)}." if is_excused(kind) else ""
        yield Word(name, FAULT, "", f"{kind.what}{soon}{unseen}{excused}")


def _profile_keys() -> Iterator[Word]:
    yield from _keys(PROFILE, "", "", ProfileHead)
    for name in REGISTRY.imported("mechanism"):
        yield from _keys(PROFILE, name, name, REGISTRY.settings("mechanism", name))
    yield from _keys(PROFILE, "devices.NAME", "", DeviceHead)
    sections: dict[Kind, str] = {
        "bus": "buses.NAME",
        "driver": "devices.NAME",
        "plant": "plant",
    }
    for kind, section in sections.items():
        for name in REGISTRY.imported(kind):
            yield from _keys(PROFILE, section, name, REGISTRY.settings(kind, name))
    for name in REGISTRY.imported("controller"):
        law = name.rpartition("/")[2]
        yield from _keys(PROFILE, f"controllers.{law}", name, REGISTRY.settings("controller", name))


def _experiment_keys() -> Iterator[Word]:
    yield from _keys(EXPERIMENT, "", "", ExperimentHead)
    for name in REGISTRY.imported("reference"):
        yield from _keys(EXPERIMENT, "reference", name, REGISTRY.settings("reference", name))
    yield from _keys(EXPERIMENT, "metrics.NAME", "", MetricSpec)


def _measures() -> Iterator[Word]:
    for mechanism in REGISTRY.imported("mechanism"):
        measures = REGISTRY.measures(mechanism, Measure)
        for name in REGISTRY.own_measures(mechanism):
            measure = measures[name]
            unit = f", {measure.unit}" if measure.unit else ""
            yield Word(name, MEASURE, mechanism, f"{measure.description}{unit}")


def _facts() -> Iterator[Word]:
    for mechanism in REGISTRY.imported("mechanism"):
        for name, kind in dict.fromkeys(REGISTRY.facts(mechanism)):  # alike of several motions
            unit = f", {kind.unit}" if kind.unit else ""
            yield Word(name, FACT, mechanism, f"{kind.description}{unit}")


def _figures() -> Iterator[Word]:
    from rig.report.figures import ANY_RUN, known_figures

    for mechanism in REGISTRY.imported("mechanism"):
        kinds = known_figures(mechanism)
        for name in REGISTRY.own_figures(mechanism):
            yield Word(name, FIGURE, mechanism, kinds[name].caption)
    for name, kind in ANY_RUN.items():
        yield Word(name, FIGURE, "", kind.caption)


def _laws() -> Iterator[Word]:
    for name in REGISTRY.imported("controller"):
        mechanism, _, law = name.rpartition("/")
        yield Word(law, LAW, mechanism, _first_sentence(REGISTRY.load("controller", name)))


def _parts() -> Iterator[Word]:
    for called, (kind, key) in PARTS.items():
        owners = {name: _owner(kind, name) for name in REGISTRY.imported(kind)}
        for name in sorted(owners, key=lambda name: (owners[name], name)):
            settings = cast("type", REGISTRY.settings(kind, name))
            said = _first_sentence(settings).partition(", beside what ")[0].rstrip(".")
            keys = ", ".join(cast("Schema", adapter(settings).json_schema()["properties"]))
            taken = f" It takes: {keys}." if keys else ""
            yield Word(name, called, owners[name], f"{said}. Named by `{key}`.{taken}")


def _owner(kind: Kind, name: str) -> str:
    """Return whose a motion or plant is; empty: it is nobody's."""
    of: Mapping[Kind, Callable[[str], Sequence[str]]] = {
        "reference": REGISTRY.references, "plant": REGISTRY.plants,
    }  # fmt: skip
    mechanisms = REGISTRY.imported("mechanism") if kind in of else ()
    return next((one for one in mechanisms if name in of[kind](one)), "")


def _first_sentence(thing: type) -> str:
    return " ".join((inspect.getdoc(thing) or "").partition("\n\n")[0].split())


def _keys(kind: str, section: str, of: str, settings: type) -> Iterator[Word]:
    schema = cast("Schema", adapter(settings).json_schema())
    definitions = cast("Mapping[str, Schema]", schema.get("$defs", {}))
    yield from _below(Word(section, kind, of, ""), schema, definitions)


def _below(word: Word, schema: Schema, definitions: Mapping[str, Schema]) -> Iterator[Word]:
    """Return the keys of a section, those of its own sections among them."""
    properties = cast("Mapping[str, Schema]", schema.get("properties", {}))
    for key, content in properties.items():
        name = f"{word.name}.{key}".lstrip(".")
        text = str(content.get("description", ""))
        default = _shown(content["default"]) if "default" in content else ""
        referred = [definitions[name] for name in _references(content)]
        sections = [section for section in referred if "properties" in section]
        own = word._replace(name=name, text=text, default="" if sections else default)
        yield own
        for section in sections:
            yield from _below(own, section, definitions)


def _references(content: Schema) -> Iterator[str]:
    """Return the names of the sections that a key may hold, also in a list or by name."""
    if "$ref" in content:
        yield str(content["$ref"]).rpartition("/")[2]
    for inner in ("items", "additionalProperties"):
        if isinstance(content.get(inner), dict):
            yield from _references(cast("Schema", content[inner]))
    for option in cast("list[Schema]", content.get("anyOf", [])):
        yield from _references(option)


def _shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_shown, value)) + "]"
    return "" if value is None else str(value)
