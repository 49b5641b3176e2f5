"""A sweep as a file: what the options of ``rig sweep`` say, in YAML."""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

from rig.config.diagnostics import Problems
from rig.config.document import parse_mapping
from rig.config.located import Node, Plain
from rig.config.named_files import with_path_beside
from rig.config.settings import build
from rig.config.yaml_loader import MAX_BYTES, read_source
from rig.hal import ConfigurationError
from rig.hal.files import read_regular
from rig.sweeping.axis import MAX_VALUES, Axis, DrawnAxis, make_axis, parse_seeds
from rig.sweeping.request import SweepRequest, as_options, as_text
from rig.sweeping.stop_rule import StopRule, parse_budget, parse_stop_rule
from rig.sweeping.sweep_keys import SweepKeys
from rig.sweeping.variations import Variations, make_variations
from rig.sweeping.written import Written, in_file

if TYPE_CHECKING:
    from numpy.typing import NDArray

Values: TypeAlias = "Sequence[object] | NDArray[np.generic]"

_OPTIONS: Final = {"set": "", "perturbation": "simulation.perturbation."}
"""Keys below which settings stand, and what their names begin with there."""


class _Parsed(NamedTuple):
    """The parts of a sweep file that have a form of their own."""

    axes: tuple[Axis | DrawnAxis, ...] = ()
    variations: tuple[Variations, ...] = ()
    seeds: Axis | None = None
    stop_when: StopRule | None = None
    seconds: float | None = None
    points: float | None = None


def is_sweep_file(source: str) -> bool:
    """Return whether a path is that of a sweep file: it says what is varied."""
    path = Path(source)
    if path.suffix not in (".yaml", ".yml"):
        return False
    try:
        text = read_regular(path, MAX_BYTES).decode(errors="replace")
    except ConfigurationError:  # whoever takes it for something else says why
        return False
    keys = {line.partition(":")[0] for line in text.splitlines()}
    return "experiment" in keys and "reference" not in keys


def load_sweep(path: Path) -> SweepRequest:
    """Load a sweep file.

    Raises
    ------
    ConfigurationError
        Something in it is wrong.
    """
    problems = Problems()
    root = parse_mapping(read_source(path), problems)
    problems.raise_if_any()
    assert isinstance(root.value, dict)
    items, parsed = dict(root.value), _Parsed()
    for key, parse in _PARSERS.items():
        node = items.get(key)
        if node is None or node.value is None:
            continue
        try:
            parsed = parse(parsed, node.plain())
        except ConfigurationError as error:
            problems.add(node.heading, f"{key}: {error}")
            del items[key]
    for key in ("experiment", "rig"):
        named = with_path_beside(items.get(key))
        if named is not None:
            items[key] = named
    keys = build(SweepKeys, root.with_items(items), problems)
    problems.raise_if_any()
    assert keys is not None
    return _request(keys, parsed, _options(root))


def axes_of(vary: Mapping[str, object], written: Written) -> tuple[Axis | DrawnAxis, ...]:
    """Return axes from settings and their values: a list, or a text as on the command line."""
    return tuple(_axis(setting, values, written) for setting, values in vary.items())


def variations_of(named: Mapping[str, object]) -> Variations:
    """Return variations from their names and the settings that each one changes.

    Raises
    ------
    ConfigurationError
        One is no mapping of settings to values, or has a name that none can have.
    """
    found = {}
    for name, settings in named.items():
        if not isinstance(settings, dict):
            raise ConfigurationError(f"{name}: expected settings with their values, as in a.b: c")
        found[name] = as_options(settings, in_file)
    return make_variations(found)


def seeds_of(value: object) -> Axis:
    """Return the axis of seeds from ``0:20``, one number, or a list of numbers."""
    if isinstance(value, list | tuple | range | np.ndarray):
        return parse_seeds(",".join(map(str, _few("seeds", value))))
    return parse_seeds(str(value))


def _axis(setting: str, values: object, written: Written) -> Axis | DrawnAxis:
    if isinstance(values, str):
        return make_axis(setting, values, written)
    if not isinstance(values, list | tuple | range | np.ndarray) or not len(_few(setting, values)):
        raise ConfigurationError(f"{setting}: expected a list of values, or a range such as 1..5:9")
    return Axis(setting, tuple(dict.fromkeys(as_text(value) for value in values)), written)


def _few(name: str, values: Values) -> Values:
    """Return values of which there are not too many; not one is looked at before."""
    try:
        count = len(values)
    except OverflowError:  # a range that is longer than anything can be
        count = sys.maxsize
    if count > MAX_VALUES:
        raise ConfigurationError(f"{name}: {count:,} values; an axis has 1 to {MAX_VALUES:,}")
    return values


def _mapping(value: Plain) -> dict[str, Plain]:
    if not isinstance(value, dict):
        raise ConfigurationError("expected settings with their values, as in a.b: c")
    return value


def _options(root: Node) -> tuple[str, ...]:
    """Return the settings of every point in the order in which the file has them."""
    options: tuple[str, ...] = ()
    for key, below in _mapping(root.plain()).items():
        if key in _OPTIONS:
            named = {f"{_OPTIONS[key]}{name}": value for name, value in _mapping(below).items()}
            options += as_options(named, in_file)
    return options


def _with_budget(parsed: _Parsed, seconds: float | None, points: float | None) -> _Parsed:
    return parsed._replace(seconds=seconds, points=points)


def _request(keys: SweepKeys, parsed: _Parsed, options: tuple[str, ...]) -> SweepRequest:
    return SweepRequest(
        keys.experiment,
        (*parsed.axes, *parsed.variations),
        parsed.seeds if keys.repeat is None else parse_seeds(f"0:{keys.repeat}"),
        keys.on,
        options,
        keys.rig,
        workers=keys.workers,
        dask=keys.dask,
        out=None if keys.out is None else Path(keys.out),
        draw_seed=keys.draw_seed,
        stop_when=parsed.stop_when,
        seconds=parsed.seconds,
        points=parsed.points,
        best=keys.metric,
        keep=-1 if keys.keep == "all" else keys.keep,
    )


def parse_keep(text: str) -> int:
    """Parse of how many of the best points the run folders are kept.

    Raises
    ------
    ConfigurationError
        It is neither a number nor ``all``.
    """
    if text == "all":
        return -1
    if not text.isdigit():
        raise ConfigurationError(f"keep {text!r}: expected a number, or all")
    return int(text)


_PARSERS: Final[dict[str, Callable[[_Parsed, Plain], _Parsed]]] = {
    "vary": lambda parsed, value: parsed._replace(axes=axes_of(_mapping(value), in_file)),
    "variations": lambda parsed, value: parsed._replace(
        variations=(variations_of(_mapping(value)),)
    ),
    "seeds": lambda parsed, value: parsed._replace(seeds=seeds_of(value)),
    "stop_when": lambda parsed, value: parsed._replace(stop_when=parse_stop_rule(str(value))),
    "budget": lambda parsed, value: _with_budget(parsed, *parse_budget(str(value))),
}
"""Those keys, and what each one puts in."""
