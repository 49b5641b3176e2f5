"""Everything that the walking legs offer to the program."""

from rig.hal.parts import MechanismParts, PlantModel

_LAWS = "controllers.gait"
_HERE = "rig.mechanisms.legs"

_CHANNELS = (
    "right_hip_yaw", "right_hip_roll", "right_hip_pitch",
    "right_knee", "right_ankle_pitch", "right_ankle_roll",
    "left_hip_yaw", "left_hip_roll", "left_hip_pitch",
    "left_knee", "left_ankle_pitch", "left_ankle_roll",
    "right_front_left", "right_front_right", "right_back_left", "right_back_right",
    "left_front_left", "left_front_right", "left_back_left", "left_back_right",
    "waist_roll", "waist_pitch", "waist_roll_rate", "waist_pitch_rate",
)  # fmt: skip
"""Joints, load cells of the soles and the tilt sensor."""

PARTS = MechanismParts(
    mechanism="legs",
    settings=f"{_HERE}.settings:LegsSettings",
    commissioning=f"{_HERE}.commissioning:steps",
    view=f"{_HERE}.mechanism:Legs",
    scene=f"{_HERE}.scene:LegsScene",
    controllers={
        "inverse": f"{_LAWS}.laws:InverseLaw",
        "sc": f"{_LAWS}.laws:LimitedNormLaw",
        "sc-trapezoid": f"{_LAWS}.laws:TrapezoidNormLaw",
        "sc-smooth": f"{_LAWS}.smooth:SmoothLaw",
        "sc-per-leg": f"{_LAWS}.per_leg:PerLegLaw",
        "min-jerk": f"{_LAWS}.laws:MinimumJerkLaw",
        "clamp": f"{_LAWS}.clamped_and_damped:ClampedLaw",
        "dls": f"{_LAWS}.clamped_and_damped:DampedLaw",
        "mink": f"{_LAWS}.mink_rival:MinkLaw",
    },
    references={
        "legs-walk": f"{_HERE}.references:WalkSettings",
        "legs-squat": f"{_HERE}.references:SquatSettings",
        "legs-footsteps": f"{_HERE}.references:FootstepsSettings",
    },
    plants={
        "legs": PlantModel(
            "drivers.sim.plants.legs_settings:LegsPlantSettings",
            "drivers.sim.plants.legs:LegsPlant",
            "drivers.sim.hazards:legs_hazards",
            channels=_CHANNELS,
        )
    },
    facts=(f"{_HERE}.fact_kinds:LEGS_FACTS",),
    measures=(f"{_HERE}.measures:LEGS_MEASURES",),
    figures=(f"{_HERE}.figures.gait:LEGS_FIGURES",),
    comparisons=(f"{_HERE}.comparison:LEGS_COMPARISON",),
    procedures=(f"{_HERE}.calibration.zeros:LegZeros", f"{_HERE}.calibration.scale:LegScale"),
)
