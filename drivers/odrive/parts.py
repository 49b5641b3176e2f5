"""Everything that the driver of axes on ODrives and its bus offer to the program."""

from rig.hal.parts import DriverParts, ProtocolParts

PARTS = DriverParts(
    settings="drivers.odrive.settings:OdriveSettings",
    device="drivers.odrive.device:OdriveServos",
    simulation="drivers.sim.nodes.odrive_wiring:WIRING",
)

PROTOCOL = ProtocolParts(
    settings="drivers.odrive.settings:OdriveBusSettings",
    bus="drivers.odrive.bus:OdriveBus",
    open="drivers.can:open_bus",
    load="drivers.can.load:check_bus_load",
    decoder="drivers.odrive.decoder:make_decoder",
    discovery="drivers.odrive.discovery:survey_odrives",
)
