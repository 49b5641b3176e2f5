"""A sweep as a file: what the options of ``rig sweep`` say, in YAML."""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from rig.config.diagnostics import Problems, nearest
from rig.config.document import parse_mapping
from rig.config.located import Plain
from rig.config.yaml_loader import MAX_BYTES, read_source
from rig.hal import ConfigurationError
from rig.hal.files import read_regular
from rig.sweeping.axis import MAX_VALUES, Axis, DrawnAxis, make_axis, parse_seeds
from rig.sweeping.request import SweepRequest, as_options, as_text
from rig.sweeping.stop_rule import parse_budget, parse_stop_rule
from rig.sweeping.variations import Variations, make_variations
from rig.sweeping.written import Written, in_file

if TYPE_CHECKING:
    from numpy.typing import NDArray

Values: TypeAlias = "Sequence[object] | NDArray[np.generic]"

PERTURBATION: Final = "simulation.perturbation"


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
    content = root.plain()
    assert isinstance(content, dict)
    for key in content:
        if key not in _READERS:
            place, _ = root.descend((key,))
            problems.add(place.heading, f"unknown key {key!r}", nearest(key, _READERS))
    problems.raise_if_any()
    if "experiment" not in content:
        raise ConfigurationError(f"{path}: a sweep names its experiment")
    if "seeds" in content and "repeat" in content:
        raise ConfigurationError(f"{path}: seeds and repeat say the same: leave out one")
    request = SweepRequest(str(content["experiment"]))
    for key, value in content.items():
        try:
            request = _READERS[key](request, value)
        except (ConfigurationError, TypeError, ValueError) as error:
            raise ConfigurationError(f"{path}: {key}: {error}") from error
    return request


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


def _perturbation(request: SweepRequest, value: Plain) -> SweepRequest:
    more = {f"{PERTURBATION}.{name}": bound for name, bound in _mapping(value).items()}
    return replace(request, options=(*request.options, *as_options(more, in_file)))


def _repeat(request: SweepRequest, value: Plain) -> SweepRequest:
    return replace(request, seeds=parse_seeds(f"0:{value}"))


def _budget(request: SweepRequest, value: Plain) -> SweepRequest:
    seconds, points = parse_budget(str(value))
    return replace(request, seconds=seconds, points=points)


_READERS: Final[dict[str, Callable[[SweepRequest, Plain], SweepRequest]]] = {
    "experiment": lambda request, value: replace(request, experiment=str(value)),
    "on": lambda request, value: replace(request, on=str(value)),
    "rig": lambda request, value: replace(request, rig=str(value)),
    "set": lambda request, value: replace(
        request, options=(*request.options, *as_options(_mapping(value), in_file))
    ),
    "perturbation": _perturbation,
    "vary": lambda request, value: replace(
        request, axes=(*axes_of(_mapping(value), in_file), *request.axes)
    ),
    "variations": lambda request, value: replace(
        request, axes=(*request.axes, variations_of(_mapping(value)))
    ),
    "seeds": lambda request, value: replace(request, seeds=seeds_of(value)),
    "repeat": _repeat,
    "draw_seed": lambda request, value: replace(request, draw_seed=int(str(value))),
    "stop_when": lambda request, value: replace(request, stop_when=parse_stop_rule(str(value))),
    "budget": _budget,
    "metric": lambda request, value: replace(request, best=str(value)),
    "keep": lambda request, value: replace(request, keep=parse_keep(str(value))),
    "workers": lambda request, value: replace(request, workers=int(str(value))),
    "dask": lambda request, value: replace(request, dask=str(value)),
    "out": lambda request, value: replace(request, out=Path(str(value))),
}
"""Every key of a sweep file, and what it changes."""


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
