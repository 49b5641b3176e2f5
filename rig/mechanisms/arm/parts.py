"""Everything that the U-R-S arm offers to the program."""

from rig.hal.parts import MechanismParts, PlantModel

_LAWS = "controllers.arm"
_HERE = "rig.mechanisms.arm"

PARTS = MechanismParts(
    mechanism="arm",
    settings=f"{_HERE}.settings:ArmSettings",
    commissioning=f"{_HERE}.commissioning:steps",
    view=f"{_HERE}.mechanism:Arm",
    scene=f"{_HERE}.scene:ArmScene",
    controllers={
        "inverse": f"{_LAWS}.plain:Inverse",
        "dls": f"{_LAWS}.plain:DampedLeastSquares",
        "servo-halt": f"{_LAWS}.plain:ServoHalt",
        "esc-paper": f"{_LAWS}.esc:EscPaper",
        "esc": f"{_LAWS}.esc:Esc",
        "look-ahead": f"{_LAWS}.look_ahead:LookAhead",
    },
    references={
        "arm-turnback": f"{_HERE}.references:TurnBack",
        "arm-dwell": f"{_HERE}.references:DwellLine",
        "arm-circle": f"{_HERE}.references:Circle",
        "arm-line": f"{_HERE}.references:Line",
        "arm-straight": f"{_HERE}.references:StraightPath",
        "arm-path": f"{_HERE}.references:PosePath",
        "arm-gamepad": f"{_HERE}.references:GamepadTwists",
        "arm-turn": f"{_HERE}.references:TurnPath",
        "arm-twist": f"{_HERE}.references:TwistRows",
    },
    plants={
        "arm": PlantModel(
            "drivers.sim.plants.arm_settings:ArmPlantSettings",
            "drivers.sim.plants.arm:ArmPlant",
            "drivers.sim.hazards:arm_hazards",
            channels=("q1", "q2", "q3", "q4", "q5", "q6"),
        )
    },
    facts=(f"{_HERE}.fact_kinds:PATH_FACTS", f"{_HERE}.fact_kinds:TWIST_FACTS"),
    measures=(
        f"{_HERE}.measures:ARM_MEASURES",
        f"{_HERE}.heard_measures:HEARD_MEASURES",
    ),
    figures=(f"{_HERE}.figures:ARM_FIGURES",),
    comparisons=(
        f"{_HERE}.twist_comparison:TWIST_COMPARISON",
        f"{_HERE}.comparison:ARM_COMPARISON",
    ),
    drawings={"urdf": f"{_HERE}.drawing.profile:of_urdf", "dh": f"{_HERE}.drawing.profile:of_dh"},
    procedures=(f"{_HERE}.calibration.zeros:ArmZeros", f"{_HERE}.calibration.links:ArmLinks"),
)
