"""Everything that a bus with CANopen devices offers to the program."""

from rig.hal.parts import ProtocolParts

PROTOCOL = ProtocolParts(
    settings="drivers.canopen.settings:CanBusSettings",
    bus="drivers.canopen.bus:CanopenBus",
    open="drivers.can:open_bus",
    load="drivers.canopen.load:check_canopen_load",
    decoder="drivers.canopen.decoder:make_decoder",
    discovery="drivers.canopen.discovery:survey_canopen",
    nodes="drivers.sim.described_wiring:WIRING",
)
