"""A cylinder as a campaign of faults knows it, made by hand."""

from rig.faults.subject import Subject
from rig.hal.world import Frames

SUBJECT = Subject(
    rig="cylinder",
    experiments=("sine", "step", "ramp"),
    period=1e-3,
    channels={"regulators": ("agonist", "antagonist"), "plant": ("agonist", "antagonist")},
    knows={
        "plant": ("wire_cut", "supply_lost", "agonist.regulator_slow", "antagonist.regulator_slow"),
        "regulators": ("silent", "wire_break", "emergency_stop"),
        "encoder": ("silent", "frozen", "jump"),
        "can0": ("frame_loss", "bus_off"),
    },
    frames={
        "regulators": Frames("can0", (0x210,), (0x290,), (0x710,)),
        "encoder": Frames("can0", (), (0x1A0,), (0x720,)),
    },
    on_bus={"can0": ("regulators", "encoder")},
    hazards=(),
    connecting=0.5,
    reading_age=15e-3,
    procedures={"friction": 49.0, "legs": 1.1},
)
