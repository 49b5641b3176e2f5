"""From a profile to a rig: the only package that knows concrete drivers and controllers."""

from rig.assembly.build import build_rig, check_fitness, check_profile, with_what_else
from rig.assembly.buses import bus_loads
from rig.assembly.channels import check_channels
from rig.assembly.on_interfaces import backend_of, parse_interfaces
from rig.assembly.production import controller_class, make_controller, make_law, plan_motion
from rig.assembly.registry import REGISTRY, InstalledParts
from rig.assembly.rig import Backend, Rig

__all__ = [
    "REGISTRY",
    "Backend",
    "InstalledParts",
    "Rig",
    "backend_of",
    "build_rig",
    "bus_loads",
    "check_channels",
    "check_fitness",
    "check_profile",
    "controller_class",
    "make_controller",
    "make_law",
    "parse_interfaces",
    "plan_motion",
    "with_what_else",
]
