"""Everything that the driver of axes on Dynamixel servos and its bus offer to the program."""

from rig.hal.parts import DriverParts, ProtocolParts

PARTS = DriverParts(
    settings="drivers.dynamixel.settings:DynamixelSettings",
    device="drivers.dynamixel.device:DynamixelServos",
    simulation="drivers.sim.dynamixel.wiring:WIRING",
)

PROTOCOL = ProtocolParts(
    settings="drivers.dynamixel.settings:SerialBusSettings",
    bus="drivers.dynamixel.bus:SerialBus",
    open="drivers.dynamixel.port:open_port",
    load="drivers.dynamixel.load:check_serial_load",
    discovery="drivers.dynamixel.discovery:survey_chain",
    line="drivers.sim.dynamixel.line:make_line",
    is_can=False,
)
