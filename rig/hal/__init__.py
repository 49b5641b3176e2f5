"""The hardware abstraction layer: small, typed, without I/O of its own."""

from rig.hal.bus import Buses, CanBus, CyclicBus, Frame
from rig.hal.clock import Clock, MonotonicClock
from rig.hal.devices import (
    ChamberLocks,
    Device,
    Doubtful,
    EmergencyStopInput,
    Homeable,
    LinearEncoder,
    MarkerCamera,
    Markers,
    PressureRegulator,
    ServoBus,
    Vector,
)
from rig.hal.errors import (
    ConfigurationError,
    ConnectionFailed,
    DeviceError,
    DeviceFault,
    EmergencyStop,
    LimitExceeded,
    LoopStalled,
    MotionRefused,
    RigError,
    SafetyError,
    StaleReading,
)
from rig.hal.reading import Reading

__all__ = [
    "Buses",
    "CanBus",
    "ChamberLocks",
    "Clock",
    "ConfigurationError",
    "ConnectionFailed",
    "CyclicBus",
    "Device",
    "DeviceError",
    "DeviceFault",
    "Doubtful",
    "EmergencyStop",
    "EmergencyStopInput",
    "Frame",
    "Homeable",
    "LimitExceeded",
    "LinearEncoder",
    "LoopStalled",
    "MarkerCamera",
    "Markers",
    "MonotonicClock",
    "MotionRefused",
    "PressureRegulator",
    "Reading",
    "RigError",
    "SafetyError",
    "ServoBus",
    "StaleReading",
    "Vector",
]
