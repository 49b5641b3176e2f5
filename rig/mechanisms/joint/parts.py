"""Everything that the spherical joint offers to the program."""

from rig.hal.parts import MechanismParts, PlantModel
from rig.mechanisms.pneumatic.reported import REPORTED

_LAWS = "controllers.spherical_joint.laws"
_HERE = "rig.mechanisms.joint"
_PLANTS = "drivers.sim.plants"

PARTS = MechanismParts(
    mechanism="joint",
    settings=f"{_HERE}.settings:JointSettings",
    view=f"{_HERE}.mechanism:SphericalJoint",
    scene=f"{_HERE}.scene:JointScene",
    bench=f"{_HERE}.bench:JointBench",
    measured_loop=f"{_HERE}.measured_loop:loop_of_run",
    commissioning=f"{_HERE}.commissioning:steps",
    controllers={
        "pid": f"{_LAWS}:JointPid",
        "pid-friction": f"{_LAWS}:JointPidFriction",
        "cascade": f"{_LAWS}:JointCascade",
        "super-twisting": f"{_LAWS}:JointSuperTwisting",
    },
    references={
        "joint-circle": f"{_HERE}.references.circle:JointCircle",
        "joint-poses": f"{_HERE}.references.poses:JointPoses",
        "joint-spiral": f"{_HERE}.references.sweeps:JointSpiral",
        "joint-probe": f"{_HERE}.references.probe:JointProbe",
        "joint-stiffness": f"{_HERE}.references.sweeps:JointStiffness",
    },
    plants={
        name: PlantModel(
            f"{_PLANTS}.spherical_joint_settings:{settings}",
            f"{_PLANTS}.spherical_joint:{plant}",
            "drivers.sim.hazards:joint_hazards",
            is_restorable=True,
            lends_kernel=True,
            channels=("ch1", "ch2", "ch3", "ch4"),
        )
        for name, settings, plant in (
            ("spherical-joint-ideal", "SphericalJointPlantSettings", "SphericalJointPlant"),
            ("spherical-joint", "RealJointSettings", "SphericalJointPlant"),
            ("valve-joint", "ValveJointSettings", "ValveJointPlant"),
        )
    },
    facts=(f"{_HERE}.fact_kinds:JOINT_FACTS",),
    measures=(
        f"{_HERE}.measures.tracking:JOINT_MEASURES",
        f"{_HERE}.measures.camera:CAMERA_MEASURES",
        f"{_HERE}.measures.laps:LAP_MEASURES",
        f"{_HERE}.measures.stiffness:STIFFNESS_MEASURES",
        "rig.mechanisms.pneumatic.cost:JOINT_COSTS",
    ),
    reported=REPORTED,
    figures=(
        f"{_HERE}.figures.tracking:JOINT_FIGURES",
        f"{_HERE}.figures.camera:CAMERA_FIGURES",
        f"{_HERE}.figures.health:HEALTH_FIGURES",
        f"{_HERE}.figures.maps:MAP_FIGURES",
        f"{_HERE}.figures.repeatability:REPEATABILITY_FIGURES",
        "rig.mechanisms.pneumatic.margins_figure:MARGINS_FIGURES",
    ),
    comparisons=(f"{_HERE}.comparison:JOINT_COMPARISON",),
    procedures=(
        f"{_HERE}.calibration.procedures:regulators",
        f"{_HERE}.calibration.procedures:encoders",
        f"{_HERE}.calibration.procedures:valves",
        f"{_HERE}.calibration.procedures:wires",
        f"{_HERE}.calibration.procedures:response",
        f"{_HERE}.calibration.friction:JointFrictionFit",
        f"{_HERE}.calibration.procedures:leak",
        f"{_HERE}.calibration.lens:Lens",
        f"{_HERE}.calibration.camera:Camera",
        f"{_HERE}.calibration.geometry:Geometry",
    ),
)
