"""Everything that the crank offers to the program."""

from rig.hal.parts import MechanismParts, PlantModel

_HERE = "crank_rig.crank"

PARTS = MechanismParts(
    mechanism="crank",
    settings=f"{_HERE}.settings:CrankSettings",
    view=f"{_HERE}.mechanism:Crank",
    scene=f"{_HERE}.scene:CrankScene",
    controllers={
        "cross-coupled": f"{_HERE}.laws:CrossCoupled",
        "independent": f"{_HERE}.laws:Independent",
    },
    references={"crank-turns": f"{_HERE}.references:CrankTurns"},
    plants={
        "crank": PlantModel(
            f"{_HERE}.plant:CrankPlantSettings",
            f"{_HERE}.plant:CrankPlant",
            f"{_HERE}.hazards:crank_hazards",
        )
    },
    measures=(f"{_HERE}.measures:CRANK_MEASURES",),
    figures=(f"{_HERE}.figures:CRANK_FIGURES",),
    comparisons=(f"{_HERE}.figures:CRANK_COMPARISON",),
    procedures=(f"{_HERE}.calibration:RodZero",),
)
