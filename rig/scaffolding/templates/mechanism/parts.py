"""Everything that the mechanism offers to the program, under the names that profiles use."""

from rig.hal.parts import MechanismParts, PlantModel

_HERE = "rig.scaffolding.templates.mechanism"

PARTS = MechanismParts(
    mechanism="my-rig",
    settings=f"{_HERE}.settings:MyRigSettings",
    view=f"{_HERE}.mechanism:MyRig",
    controllers={"trimmed": f"{_HERE}.laws:Trimmed"},
    references={"my-rig-turns": f"{_HERE}.references:MyRigTurns"},
    plants={
        "my-rig": PlantModel(
            f"{_HERE}.plant:MyRigPlantSettings",
            f"{_HERE}.plant:MyRigPlant",
            f"{_HERE}.hazards:my_rig_hazards",
        )
    },
)
