"""Everything that one antagonistic pair offers to the program."""

from rig.hal.parts import MechanismParts, PlantModel
from rig.mechanisms.pneumatic.reported import REPORTED

_LAWS = "controllers.cylinder"
_HERE = "rig.mechanisms.cylinder"
_PAIR = "antagonistic_pair:AntagonisticPairPlant"

PARTS = MechanismParts(
    mechanism="cylinder",
    settings=f"{_HERE}.settings:CylinderSettings",
    view=f"{_HERE}.mechanism:AntagonisticPair",
    scene=f"{_HERE}.scene:PairScene",
    bench=f"{_HERE}.bench:PairBench",
    measured_loop=f"{_HERE}.measured_loop:loop_of_run",
    commissioning=f"{_HERE}.commissioning:steps",
    controllers={
        "pid": f"{_LAWS}.pid:Pid",
        "pid-friction": f"{_LAWS}.pid_friction:PidFriction",
        "cascade": f"{_LAWS}.cascade:Cascade",
        "super-twisting": f"{_LAWS}.super_twisting:SuperTwisting",
    },
    references={
        "sine": f"{_HERE}.references:Sine",
        "staircase": f"{_HERE}.references:Staircase",
        "step": f"{_HERE}.references:Step",
        "ramp": f"{_HERE}.references:Ramp",
        "probe": f"{_HERE}.probe:Probe",
    },
    plants={
        name: PlantModel(
            f"drivers.sim.plants.{settings}",
            f"drivers.sim.plants.{plant}",
            "drivers.sim.hazards:pair_hazards",
            is_restorable=True,
            lends_kernel=True,
            channels=("agonist", "antagonist"),
        )
        for name, settings, plant in (
            ("antagonistic-pair-ideal", "settings:PlantSettings", _PAIR),
            ("antagonistic-pair", "settings:RealPairSettings", _PAIR),
            (
                "valve-pair",
                "valve_settings:ValvePairSettings",
                "valve_pair:ValvePairPlant",
            ),
        )
    },
    measures=(f"{_HERE}.measures:PAIR_MEASURES", "rig.mechanisms.pneumatic.cost:PAIR_COSTS"),
    reported=REPORTED,
    figures=(
        f"{_HERE}.figures:PAIR_FIGURES",
        f"{_HERE}.step_figure:STEP_FIGURES",
        f"{_HERE}.frequency_figure:PAIR_RESPONSE",
        "rig.mechanisms.pneumatic.margins_figure:MARGINS_FIGURES",
    ),
    comparisons=(f"{_HERE}.comparison:PAIR_COMPARISON",),
    procedures=(
        f"{_HERE}.calibration.procedures:regulators",
        f"{_HERE}.calibration.procedures:encoders",
        f"{_HERE}.calibration.procedures:valves",
        f"{_HERE}.calibration.procedures:wires",
        f"{_HERE}.calibration.procedures:response",
        f"{_HERE}.calibration.friction:PairFriction",
        f"{_HERE}.calibration.procedures:leak",
    ),
)
