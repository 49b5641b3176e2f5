"""The whole contract between the program and what it runs: small, typed, without I/O of its own.

What is not written here may not be relied on. `parts` is what a package offers, `mechanism`,
`motion` and `controller` what the loop runs, `devices`, `driver` and `bus` what drivers are,
`plant` what is simulated.
"""

from rig.hal.bus import Buses, BusLoad, CanBus, CyclicBus, FastCanBus, Frame, FrameLoad
from rig.hal.clock import Clock, MonotonicClock
from rig.hal.columns import Column
from rig.hal.controller import Controller, Law
from rig.hal.devices import (
    Device,
    InertialSensor,
    LinearEncoder,
    LoadCells,
    MarkerCamera,
    Markers,
    PressureRegulator,
    ProportionalValves,
    ServoBus,
    Vector,
    device_column,
    not_standing,
)
from rig.hal.driver import Address, BusSettings, DeviceFile, DriverSettings, Endpoint
from rig.hal.errors import (
    ConfigurationError,
    ConnectionFailed,
    ContractBroken,
    DeviceError,
    DeviceFault,
    EmergencyStop,
    LimitExceeded,
    LoopStalled,
    MotionRefused,
    RigError,
    SafetyError,
    SeveralErrors,
    StaleReading,
)
from rig.hal.freeze import Freeze
from rig.hal.mechanism import Mechanism
from rig.hal.motion import Fact, Motion, Segment
from rig.hal.picking import DevicePicker, pick_device
from rig.hal.plant import (
    AiryPlant,
    HandledPlant,
    MeasuredPlant,
    PhysicsSettings,
    Plant,
    RestorablePlant,
)
from rig.hal.quantities import Margin
from rig.hal.reading import Reading
from rig.hal.stop_input import EmergencyStopInput
from rig.hal.targets import Targets

__all__ = [
    "Address",
    "AiryPlant",
    "BusLoad",
    "BusSettings",
    "Buses",
    "CanBus",
    "Clock",
    "Column",
    "ConfigurationError",
    "ConnectionFailed",
    "ContractBroken",
    "Controller",
    "CyclicBus",
    "Device",
    "DeviceError",
    "DeviceFault",
    "DeviceFile",
    "DevicePicker",
    "DriverSettings",
    "EmergencyStop",
    "EmergencyStopInput",
    "Endpoint",
    "Fact",
    "FastCanBus",
    "Frame",
    "FrameLoad",
    "Freeze",
    "HandledPlant",
    "InertialSensor",
    "Law",
    "LimitExceeded",
    "LinearEncoder",
    "LoadCells",
    "LoopStalled",
    "Margin",
    "MarkerCamera",
    "Markers",
    "MeasuredPlant",
    "Mechanism",
    "MonotonicClock",
    "Motion",
    "MotionRefused",
    "PhysicsSettings",
    "Plant",
    "PressureRegulator",
    "ProportionalValves",
    "Reading",
    "RestorablePlant",
    "RigError",
    "SafetyError",
    "Segment",
    "ServoBus",
    "SeveralErrors",
    "StaleReading",
    "Targets",
    "Vector",
    "device_column",
    "not_standing",
    "pick_device",
]
