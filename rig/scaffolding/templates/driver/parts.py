"""What this package adds: a driver, simulated by what it says of its frames."""

from rig.hal.parts import DriverParts

PARTS = DriverParts(
    settings="rig.scaffolding.templates.driver.settings:MySensorSettings",
    device="rig.scaffolding.templates.driver.device:MySensor",
)
