"""Make the JSON Schema of profiles and experiments, for editors."""

from functools import reduce
from operator import or_
from types import GenericAlias
from typing import Annotated, Final, Literal, NotRequired, Required, TypeAlias

from pydantic import Field, TypeAdapter

from rig.config.experiment import ExperimentHead
from rig.config.heads import DeviceHead, ProfileHead
from rig.config.models import MetricSpec
from rig.config.named_settings import Kind, Registry, controller_names
from rig.config.profile import DEFAULT_PROTOCOL
from rig.config.settings import NUMBER_AND_UNIT, Entries, annotation, closed_mapping, entries_of

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"
_PARTIAL: Final = "Partial"
_LAW: Final = ("controller", "law")
"""What an experiment may call its controller."""

Schema: TypeAlias = dict[str, object]

_Extends = Annotated[str, Field(description="A file of the same kind that this one changes.")]
_Wish = Annotated[
    bool | dict[str, object] | None,
    Field(description="true: there must be one, false: none is laid over; else if there is one."),
]


def profile_schema(registry: Registry) -> Schema:
    """Return the JSON Schema of a profile.

    Parameters
    ----------
    registry : Registry
        Every driver, controller, mechanism, plant and bus in it becomes an alternative.

    Returns
    -------
    dict
        JSON Schema, draft 2020-12. Where a file extends another, no key is required.
    """
    mechanisms = registry.imported("mechanism")
    device = {**entries_of(DeviceHead), "calibration": NotRequired[_Wish]}
    alike: dict[str, list[object]] = {}
    for name in registry.imported("controller"):
        settings = annotation(registry.settings("controller", name))
        alike.setdefault(name.rpartition("/")[2], []).append(settings)
    controllers = {name: NotRequired[reduce(or_, kinds)] for name, kinds in alike.items()}
    entries: dict[str, object] = {
        "extends": NotRequired[_Extends],
        **entries_of(ProfileHead),
        "mechanism": Required[_one_of(mechanisms)],
        "buses": NotRequired[_named(_buses(registry))],
        "devices": NotRequired[_named(_alternatives(registry, "driver", "driver", device))],
        "controllers": NotRequired[closed_mapping("Controllers", controllers)],
        "plant": NotRequired[_alternatives(registry, "plant", "model", {})],
        "calibration": NotRequired[_Wish],
    }
    for name in mechanisms:
        entries[name] = NotRequired[annotation(registry.settings("mechanism", name))]
    return _finished("Profile", entries, {}, [_own_parts(registry, name) for name in mechanisms])


def experiment_schema(registry: Registry) -> Schema:
    """Return the JSON Schema of an experiment.

    Parameters
    ----------
    registry : Registry
        Every controller and reference in it becomes an alternative.

    Returns
    -------
    dict
        JSON Schema, draft 2020-12. Where a file extends another, no key is required.
    """
    quantity = Annotated[str, Field(pattern=NUMBER_AND_UNIT)]
    bound = NotRequired[float | quantity | None]
    metric = closed_mapping("Metric", {**entries_of(MetricSpec), "max": bound, "min": bound})
    entries: dict[str, object] = {
        "extends": NotRequired[_Extends],
        **{key: made for key, made in entries_of(ExperimentHead).items() if key not in _LAW},
        **{key: NotRequired[_one_of(controller_names(registry))] for key in _LAW},
        "reference": Required[_alternatives(registry, "reference", "kind", {})],
        "metrics": NotRequired[_named(metric)],
    }
    whole: Schema = {"oneOf": [{"required": [key]} for key in _LAW]}
    rules: list[Schema] = [{"not": {"required": list(_LAW)}}, *_laws_of_references(registry)]
    return _finished("Experiment", entries, whole, rules)


def _own_parts(registry: Registry, mechanism: str) -> Schema:
    """Return what a profile of a mechanism has: its own section, and laws of its own only."""
    laws = controller_names(registry, mechanism)
    others = [name for name in registry.imported("mechanism") if name != mechanism]
    return {
        "if": {"properties": {"mechanism": {"const": mechanism}}, "required": ["mechanism"]},
        "then": {
            "properties": {
                "controllers": {"propertyNames": {"enum": list(laws)}},
                **dict.fromkeys(others, False),
            }
        },
    }


def _laws_of_references(registry: Registry) -> list[Schema]:
    """Return which laws follow each reference: those of the mechanisms that have it."""
    laws: dict[str, set[str]] = {}
    for mechanism in registry.imported("mechanism"):
        for reference in registry.references(mechanism):
            laws.setdefault(reference, set()).update(controller_names(registry, mechanism))
    return [
        {
            "if": {
                "properties": {
                    "reference": {"properties": {"kind": {"const": name}}, "required": ["kind"]}
                },
                "required": ["reference"],
            },
            "then": {"properties": {key: {"enum": sorted(known)} for key in _LAW}},
        }
        for name, known in sorted(laws.items())
    ]


def _named(below: object) -> object:
    """Return a mapping whose values are known at run time only."""
    return GenericAlias(dict, (str, below))


def _buses(registry: Registry) -> object:
    unsaid = closed_mapping("bus", entries_of(registry.settings("bus", DEFAULT_PROTOCOL)))
    return or_(_alternatives(registry, "bus", "protocol", {}), unsaid)


def _one_of(names: tuple[str, ...]) -> object:
    return Literal[names] if names else str


def _alternatives(registry: Registry, kind: Kind, key: str, common: Entries) -> object:
    """Return the union over a kind: the key that tells them apart beside each one's settings."""
    made = [
        closed_mapping(
            f"{kind}_{name}".replace("-", "_"),
            {
                key: Required[_one_of((name,))],
                **common,
                **entries_of(registry.settings(kind, name)),
            },
        )
        for name in registry.imported(kind)
    ]
    return reduce(or_, made) if made else dict[str, object]


def _finished(title: str, entries: Entries, whole: Schema, rules: list[Schema]) -> Schema:
    """Return the schema of a kind of file.

    Parameters
    ----------
    title : str
        What it is called.
    entries : mapping
        Its keys.
    whole : dict
        What holds for a file that extends no other, beside its keys.
    rules : list of dict
        What holds for every file, beside its keys.
    """
    full = TypeAdapter(closed_mapping(title, entries)).json_schema()
    definitions = full.pop("$defs", {})
    partial = _without_required(full)
    definitions |= {name + _PARTIAL: _without_required(item) for name, item in definitions.items()}
    definitions |= {title: full, title + _PARTIAL: partial}
    return {
        "$schema": DIALECT,
        "title": title,
        "if": {"required": ["extends"]},
        "then": {"$ref": f"#/$defs/{title}{_PARTIAL}"},
        "else": {"$ref": f"#/$defs/{title}", **whole},
        "allOf": rules,
        "$defs": definitions,
    }


def _without_required(schema: object) -> object:
    """Return the schema of a file that changes another: any key may stand in the other one."""
    if isinstance(schema, list):
        return [_without_required(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        key: item + _PARTIAL if key == "$ref" else _without_required(item)
        for key, item in schema.items()
        if not (key == "required" and isinstance(item, list))
    }
