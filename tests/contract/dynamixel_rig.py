"""Emulated Dynamixel servos under their production driver, for the suite of all servo buses."""

from types import SimpleNamespace

from servo_bench import PERIOD, LaggedJoints, ServoRig

from drivers.dynamixel.bus import SerialBus
from drivers.dynamixel.device import DynamixelServos
from drivers.dynamixel.settings import DynamixelAxisSettings, DynamixelSettings, SerialBusSettings
from drivers.sim.clock import SimClock
from drivers.sim.dynamixel.line import EmulatedSerialBus
from drivers.sim.dynamixel.wiring import emulate_dynamixel
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.wiring import Installed


class DynamixelRig(ServoRig):
    """A chain on a serial line in virtual time, with the calls of the other rigs."""

    def __init__(self, plant, settings, *, bus_settings, faults, latency, loss):
        self.plant = plant
        (node,) = emulate_dynamixel(
            Installed("arm", settings, plant, tuple(range(len(settings.joints))))
        )
        self.side = EmulatedSerialBus("chain", bus_settings.baudrate, [node])
        self.frames = []
        self.side.monitor = lambda t, data: self.frames.append((t, data))
        world = SimpleNamespace(seed=1, bus_latency=latency, frame_loss=loss, faults=faults)
        self.rig = EmulatedRig(plant, [self.side], world)
        self.clock = SimClock(self.rig)
        self.bus = SerialBus("chain", bus_settings, lambda: self.side.port, self.clock, PERIOD)
        self.driver = DynamixelServos("arm", settings, self.bus)


def dynamixel_settings(joints=2, **changes):
    """Joints that differ in sign, offset and gear."""
    return DynamixelSettings(
        joints={
            f"q{k + 1}": DynamixelAxisSettings(
                id=k + 1,
                gear=1.0 + 0.5 * k,
                reversed=bool(k % 2),
                offset=0.1 * k,
                limits=(-2.0, 2.0),
            )
            for k in range(joints)
        },
        **{"mode": "extended_position", **changes},
    )


def dynamixel_rig(
    joints=2, *, plant=None, bus_settings=None, faults=(), latency=3e-4, loss=0.0, **changes
):
    """Return a rig of emulated Dynamixel servos under the production driver."""
    return DynamixelRig(
        plant or LaggedJoints(joints),
        dynamixel_settings(joints, **changes),
        bus_settings=SerialBusSettings(
            "emulated", **{"baudrate": 2_000_000, **(bus_settings or {})}
        ),
        faults=faults,
        latency=latency,
        loss=loss,
    )
