"""What a sweep file may say: its keys, for the loader and for the schema of an editor."""

from dataclasses import dataclass, field
from typing import Annotated, Final, Literal

from annotated_types import Interval, MaxLen, MinLen
from pydantic import Field

from rig.config.schema import DIALECT, Schema
from rig.config.settings import NUMBER, NUMBER_AND_UNIT, adapter
from rig.config.simulation_models import Perturbation
from rig.hal.rules import Rules
from rig.sweeping.axis import MAX_VALUES
from rig.sweeping.variations import NOMINAL, WORST

_SEEDS: Final = r"^\s*[0-9]+(\s*:\s*[0-9]+|(\s*,\s*[0-9]+)*)\s*$"
_STOP: Final = rf"^\s*[\w.+-]+\s*(<=|>=|<|>)\s*{NUMBER}.*$"
_BUDGET: Final = rf"^\s*[0-9]+\s*points?\s*$|{NUMBER_AND_UNIT}"
_NAME: Final = r"^([A-Za-z]|[^\x00-\x7f])"
_Many = Annotated[tuple[object, ...], MinLen(1), MaxLen(MAX_VALUES)]


@dataclass(frozen=True, slots=True)
class SweepKeys:
    """The keys of a sweep file.

    Parameters
    ----------
    experiment : str
        A name, or the path of a file from this one on.
    on : str
        Where every point runs.
    rig : str, optional
        Another rig than the experiment's: a name or a path, as `experiment`.
    set : dict
        Settings of every point by their dotted names, as for ``--set``.
    perturbation : Perturbation
        Bounds on how the simulated rig may differ from its profile; every seed draws anew.
    vary : dict
        Settings by their dotted names with the values of each: a list, or a text as for
        ``--vary``.
    variations : dict, optional
        Sets of settings by a name that begins with a letter.
    seeds : int, str or list of int, optional
        Seeds of the simulation: ``0:20`` is 0 to 19.
    repeat : int, optional
        So many seeds from 0.
    draw_seed : int
        Of axes that are drawn.
    stop_when : str, optional
        Ends the sweep with the first such point: ``tracking_rms < 0.1 mm``.
    budget : str, optional
        Begin no point after ``30 min``, or ``500 points``.
    metric : str, optional
        The metric to draw, and to be best in; default: the first one.
    keep : int or str
        Of how many of the best the run folder is kept; ``all``: of all.
    workers : int
        How many points at once; 0: one for each processor.
    dask : str, optional
        A scheduler's address or file.
    out : str, optional
        The sweep's folder.
    """

    experiment: Annotated[str, MinLen(1)]
    on: Literal["sim", "virtual", "vcan", "hardware"] = "virtual"
    rig: str | None = None
    set: dict[str, object] = field(default_factory=dict)
    perturbation: Perturbation = field(default_factory=Perturbation)
    vary: dict[str, str | _Many] = field(default_factory=dict)
    variations: Annotated[dict[str, Annotated[dict[str, object], MinLen(1)]], MinLen(1)] | None = (
        None
    )
    seeds: (
        Annotated[int, Interval(ge=0)]
        | Annotated[str, Field(pattern=_SEEDS)]
        | Annotated[tuple[Annotated[int, Interval(ge=0)], ...], MinLen(1), MaxLen(MAX_VALUES)]
        | None
    ) = None
    repeat: Annotated[int, Interval(ge=1, le=MAX_VALUES)] | None = None
    draw_seed: Annotated[int, Interval(ge=0)] = 0
    stop_when: Annotated[str, Field(pattern=_STOP)] | None = None
    budget: Annotated[str, Field(pattern=_BUDGET)] | None = None
    metric: str | None = None
    keep: Annotated[int, Interval(ge=0)] | Literal["all"] = 3
    workers: Annotated[int, Interval(ge=0, le=1024)] = 0
    dask: str | None = None
    out: str | None = None

    def __post_init__(self) -> None:
        with Rules() as rule:
            if self.seeds is not None and self.repeat is not None:
                rule.broken("seeds and repeat say the same: leave out one")


def sweep_schema() -> Schema:
    """Return the JSON Schema of a sweep file, draft 2020-12."""
    made = adapter(SweepKeys).json_schema()
    named = next(arm for arm in made["properties"]["variations"]["anyOf"] if "minProperties" in arm)
    named["propertyNames"] = {"pattern": _NAME, "not": {"enum": [NOMINAL, WORST]}}
    said_twice = {"not": {"required": ["seeds", "repeat"]}}
    return {"$schema": DIALECT, **made, **said_twice, "title": "Sweep"}
