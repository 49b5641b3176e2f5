"""Everything that the drivers of actuators behind CiA 401 modules offer to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="drivers.cia401.settings:Cia401Settings",
    device="drivers.cia401.device:Cia401Regulators",
    simulation="drivers.sim.nodes.cia401_wiring:WIRING",
)

VALVES = DriverParts(
    settings="drivers.cia401.valve_settings:Cia401ValvesSettings",
    device="drivers.cia401.valves:Cia401Valves",
    simulation="drivers.sim.nodes.cia401_valves_wiring:WIRING",
)
"""What a profile says of a CiA 401 module with proportional valves and chamber sensors on it."""
