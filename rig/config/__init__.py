"""Profiles, experiments and calibrations: strict YAML in, checked plain data out.

Names are imported on first use, since validation costs a tenth of a second at start.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rig.config.diagnostics import ProfileError
    from rig.config.dump import dump_resolved
    from rig.config.experiment import EXPERIMENT_KEYS, load_experiment
    from rig.config.models import (
        BusEntry,
        DeviceEntry,
        Experiment,
        MetricSpec,
        Profile,
        ReferenceEntry,
    )
    from rig.config.names import find_configs, find_file, list_files
    from rig.config.profile import PROFILE_KEYS, load_profile, rig_name
    from rig.config.schema import experiment_schema, profile_schema
    from rig.config.simulation_models import Perturbation, SimulationSettings
    from rig.hal.formats import format_against, format_quantity, format_to

_MODULES = (
    "names",
    "simulation_models",
    "models",
    "diagnostics",
    "dump",
    "experiment",
    "profile",
    "schema",
)
"""Homes of what this package offers, those first that import little."""

__all__ = [
    "EXPERIMENT_KEYS", "PROFILE_KEYS", "BusEntry", "DeviceEntry", "Experiment", "MetricSpec",
    "Perturbation", "Profile", "ProfileError", "ReferenceEntry", "SimulationSettings",
    "dump_resolved", "experiment_schema", "find_configs", "find_file", "format_against",
    "format_quantity", "format_to", "list_files", "load_experiment", "load_profile",
    "profile_schema", "rig_name",
]  # fmt: skip


def __getattr__(name: str) -> object:
    if name in __all__:
        homes = ("rig.hal.formats", *(f"{__name__}.{home}" for home in _MODULES))
        for module in map(import_module, homes):
            if name in vars(module):
                return vars(module)[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
