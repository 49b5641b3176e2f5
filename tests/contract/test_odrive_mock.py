"""The ODrive driver against somebody else's axis: the mock of the `odrive-can` package.

The mock works with asyncio and the wall clock, so the loop runs in real time here, and the
time-outs are generous. It answers every remote frame with zeros, but for what is filled in here.
"""

import asyncio
import threading
import time

import pytest

can = pytest.importorskip("can")
mock = pytest.importorskip("odrive_can.mock")

from drivers.can.fast_path import AdaptedBus  # noqa: E402
from drivers.odrive.bus import OdriveBus  # noqa: E402
from drivers.odrive.device import OdriveServos  # noqa: E402
from drivers.odrive.settings import (  # noqa: E402
    OdriveAxisSettings,
    OdriveBusSettings,
    OdriveSettings,
)
from rig.hal import ConnectionFailed, MonotonicClock  # noqa: E402

NODE = 3
PERIOD = 0.01
VERSION = {"Fw_Version_Major": 0, "Fw_Version_Minor": 6, "Fw_Version_Revision": 10}


class Mock(mock.ODriveCANMock):
    """Knows its version, sends fast enough for a loop, and can be stopped."""

    version = VERSION

    def send_message(self, msg_name, msg_dict=None, rtr=False):
        if msg_name.endswith("Get_Version"):
            msg_dict = self.version
        super().send_message(msg_name, msg_dict, rtr)

    async def main(self):
        async with asyncio.TaskGroup() as group:
            self.stop = asyncio.get_running_loop().call_soon_threadsafe
            self.tasks = [
                group.create_task(self.heartbeat_loop(0.02)),
                group.create_task(self.encoder_loop(0.005)),
                group.create_task(self.message_handler()),
            ]


@pytest.fixture
def live(request, record_property):
    """Make a driver on the mock; what they exchanged is counted."""
    made = []

    def make(**settings):
        made.append(LiveMock(request.node.name, **settings))
        return made[-1]

    yield make
    for rig in made:
        counts = rig.bus.statistics()
        frames = int(counts["frames_in"] + counts["frames_out"])
        record_property("exchanges", ("the ODrive driver on odrive-can's mock", frames))


class LiveMock:
    def __init__(self, channel, **settings):
        self.mock_bus = can.Bus(channel, interface="virtual")
        self.mock = Mock(NODE, can_bus=self.mock_bus)
        self.mock.set_rate_of_change(5.0)
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.clock = MonotonicClock()
        self.bus = OdriveBus(
            "can0",
            OdriveBusSettings("virtual", channel),
            lambda: AdaptedBus(can.Bus(channel, interface="virtual")),
            self.clock,
            PERIOD,
        )
        joint = OdriveAxisSettings(axis=NODE, gear=6.283185307179586, following_time=1.0)
        self.driver = OdriveServos(
            "arm",
            OdriveSettings(
                joints={"elbow": joint},
                enable_time=8.0,
                encoder_period=PERIOD,
                fault_after=200,
                **settings,
            ),
            self.bus,
        )

    def _run(self):
        try:
            asyncio.run(self.mock.main())
        except* asyncio.CancelledError:
            pass

    def __enter__(self):
        self.thread.start()
        self.bus.open()
        return self

    def __exit__(self, *_):
        self.driver.close()
        self.bus.close()
        for task in self.mock.tasks:
            self.mock.stop(task.cancel)
        self.thread.join(5.0)
        self.mock.notifier.stop(0.1)
        self.mock_bus.shutdown()

    def cycle(self, command=None):
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        if command is not None:
            command()
        self.bus.transmit(now)
        self.clock.sleep_until(now + PERIOD)

    def until(self, condition, command=None, patience=10.0):
        deadline = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < deadline, "it never happened"
            self.cycle(command)


@pytest.mark.parametrize("mode", ["position", "velocity"])
def test_the_foreign_axis_is_configured_enabled_moved_and_released(mode, live):
    with live(mode=mode) as live:
        live.driver.connect()
        live.driver.arm()
        live.until(lambda: live.driver.is_enabled)
        axis = live.mock.odrive
        assert axis.axis_state == "CLOSED_LOOP_CONTROL"
        assert axis.control_mode == f"{mode.upper()}_CONTROL"
        assert axis.input_mode == "PASSTHROUGH"
        live.until(
            lambda: live.driver.positions().value[0] > 0.1,
            lambda: live.driver.command_velocities((0.5,)),
        )
        if mode == "position":
            assert axis.model.setpoint > 0.1, "turns: the gear makes one turn a radian"
        else:
            assert axis.model.setpoint == pytest.approx(0.5)
        live.driver.close()
        deadline = time.monotonic() + 5.0
        while axis.axis_state != "IDLE":
            assert time.monotonic() < deadline
            time.sleep(0.01)


def test_a_foreign_axis_with_old_firmware_is_refused(live):
    with live() as live:
        live.mock.version = {"Fw_Version_Minor": 5, "Fw_Version_Revision": 6}
        with pytest.raises(ConnectionFailed, match=r"firmware 0\.5\.6.*0\.6 or later"):
            live.driver.connect()
