"""What is driven by a scripted CiA 401 module with two analogue outputs, two regulators first."""

from scripted_bus import Bench, ScriptedNode, common_objects, u8, u16, u32

from drivers.cia401.channel_settings import MonitorSignal, RegulatorChannel, SetpointSignal
from drivers.cia401.device import Cia401Regulators
from drivers.cia401.settings import Cia401Settings, FollowingSettings


def channel(sub):
    return RegulatorChannel(
        SetpointSignal(sub=sub, voltage=(0.0, 10.0), pressure=(0.0, 900e3)),
        MonitorSignal(sub=sub, raw=(3000.0, 15000.0), voltage=(1.0, 5.0), pressure=(0.0, 900e3)),
    )


SETTINGS = Cia401Settings(
    node=1,
    channels={"agonist": channel(1), "antagonist": channel(2)},
    supply_bit=0,
    stop_bit=0,
    following=FollowingSettings(deviation=50e3, time=0.1, response=0.05),
)
VENTED = "181#B80BB80B01"  # both monitors 3000 counts (0 Pa), the stop's contact closed
START = "201#0000000000"


class AnalogueBench(Bench):
    """A driver, and a scripted module with two analogue outputs, a supply valve and a contact."""

    def __init__(self, driver, settings, **options):
        super().__init__(**options)
        objects = common_objects(0x000F0191) | {
            (0x6206, 1): u8(0),
            (0x6207, 1): u8(0xFF),
            (0x6200, 1): u8(0),
        }
        for sub in (1, 2):
            objects |= {
                (0x6411, sub): u16(0x2FFF),
                (0x6443, sub): u8(0),
                (0x6444, sub): u32(0x7FFF),
            }
        self.node = ScriptedNode(self.interface, 1, objects)
        self.driver = driver("valves", settings, self.bus)

    def start(self, reading=VENTED):
        self.driver.connect()
        self.sent()
        self.node.sync_answers.append(reading)
        self.driver.arm()
        return self.sent()


class Regulators(AnalogueBench):
    def __init__(self, settings=SETTINGS, **options):
        super().__init__(Cia401Regulators, settings, **options)

    def run(self, *frames, setpoints=(0.0, 0.0)):
        self.interface.put(*frames)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        self.driver.set_pressure(setpoints)
        self.bus.transmit(now)
        self.clock.sleep_until(now + 0.002)
        return self.sent()
