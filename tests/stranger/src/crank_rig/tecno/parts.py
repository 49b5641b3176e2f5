"""Everything that the driver of the regulator bank offers to the program."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="crank_rig.tecno.settings:TecnoSettings",
    device="crank_rig.tecno.device:TecnoRegulators",
    simulation="crank_rig.tecno.emulated:TECNO",
)
