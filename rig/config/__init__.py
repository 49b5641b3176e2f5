"""Profiles, experiments and calibrations: strict YAML in, checked plain data out.

Names are imported on first use, since validation costs a tenth of a second at start.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rig.config.diagnostics import Diagnostic, ProfileError
    from rig.config.dump import dump_resolved
    from rig.config.experiment import EXPERIMENT_KEYS, load_experiment
    from rig.config.formats import format_against, format_quantity, format_to
    from rig.config.models import (
        BusEntry,
        Calibration,
        DeviceEntry,
        Experiment,
        FaultSpec,
        LoopSettings,
        MetricSpec,
        Perturbation,
        PlantEntry,
        Profile,
        Provenance,
        ReferenceEntry,
        SimulationSettings,
    )
    from rig.config.named_settings import Kind, Registry
    from rig.config.names import find_configs, find_file, list_files
    from rig.config.profile import PROFILE_KEYS, load_profile
    from rig.config.quantities import parse_quantity
    from rig.config.schema import experiment_schema, profile_schema

_HOME = {
    "diagnostics": ("Diagnostic", "ProfileError"),
    "experiment": ("EXPERIMENT_KEYS", "load_experiment"),
    "models": (
        "BusEntry",
        "Calibration",
        "DeviceEntry",
        "Experiment",
        "FaultSpec",
        "LoopSettings",
        "MetricSpec",
        "Perturbation",
        "PlantEntry",
        "Profile",
        "Provenance",
        "ReferenceEntry",
        "SimulationSettings",
    ),
    "names": ("find_configs", "find_file", "list_files"),
    "profile": ("PROFILE_KEYS", "load_profile"),
    "formats": ("format_against", "format_quantity", "format_to"),
    "quantities": ("parse_quantity",),
    "named_settings": ("Kind", "Registry"),
    "dump": ("dump_resolved",),
    "schema": ("experiment_schema", "profile_schema"),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}

__all__ = [
    "EXPERIMENT_KEYS",
    "PROFILE_KEYS",
    "BusEntry",
    "Calibration",
    "DeviceEntry",
    "Diagnostic",
    "Experiment",
    "FaultSpec",
    "Kind",
    "LoopSettings",
    "MetricSpec",
    "Perturbation",
    "PlantEntry",
    "Profile",
    "ProfileError",
    "Provenance",
    "ReferenceEntry",
    "Registry",
    "SimulationSettings",
    "dump_resolved",
    "experiment_schema",
    "find_configs",
    "find_file",
    "format_against",
    "format_quantity",
    "format_to",
    "list_files",
    "load_experiment",
    "load_profile",
    "parse_quantity",
    "profile_schema",
]


def __getattr__(name: str) -> Any:
    module = _MODULE_OF.get(name)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{module}"), name)
