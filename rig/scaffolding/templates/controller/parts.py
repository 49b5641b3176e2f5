"""What this package adds: the name that profiles use, and the law behind it."""

from rig.hal.parts import Additions

FOR_CYLINDER = Additions(
    mechanism="cylinder", controllers={"my-law": "rig.scaffolding.templates.controller.law:MyLaw"}
)
