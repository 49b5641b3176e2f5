"""Our emulated ODrives under the maker's own software: libodrive finds, addresses and connects.

Once it is connected, libodrive reads and writes parameters by frames of its own (``RxSdo`` with
the connection's number in the first byte) that ODrive Robotics has not published; the "CAN
Protocol" of the manual has opcode 0 or 1 there. The emulated axis keeps to the manual, and its
parameters are tested with the manual's frames (``tests/wire/test_odrive_frames.py``).
"""

import asyncio
import time

import pytest
from two_processes import PATIENCE, set_all, simulate

pytestmark = pytest.mark.vcan
try:
    from odrive.device_manager import close_device_manager, get_device_manager
    from odrive.libodrive import Device, DeviceType
except (ImportError, OSError) as reason:  # OSError: its own library lacks another
    pytest.skip(f"the package odrive cannot be used here: {reason}", allow_module_level=True)

from drivers.can.socketcan import open_socketcan  # noqa: E402

SERIALS = {f"q{k}": 0x3A0000000000 + k for k in range(1, 7)}
MOVED = 0x20


@pytest.fixture
def rig():
    settings = {f"devices__drives__joints__{joint}__serial": n for joint, n in SERIALS.items()}
    with simulate("arm-odrive", "vcan0", *set_all(**settings)) as program:
        yield
        assert program.stop() == 0
        for stream in (program.process.stdout, program.process.stderr):
            stream.close()


async def find(manager):
    """Return all six, by their serial numbers."""
    found = await asyncio.wait_for(
        manager.wait_for(interfaces=["can:vcan0"], count=len(SERIALS), return_type=Device),
        PATIENCE,
    )
    return {int(device.info.serial_number, 16): device for device in found}


def run(action):
    async def main():
        manager = get_device_manager()
        try:
            return await action(await find(manager))
        finally:
            close_device_manager()

    return asyncio.run(main())


def hears(bus, can_id):
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        frame = bus.recv(1.0)
        if frame is not None and frame.arbitration_id == can_id and not frame.is_remote_frame:
            return True
    return False


def test_the_makers_software_finds_every_axis(rig):
    async def look(found):
        return {serial: (d.info.node_id, d.info.device_type) for serial, d in found.items()}

    assert run(look) == {
        serial: (number, DeviceType.RUNTIME) for number, serial in enumerate(SERIALS.values(), 1)
    }


def test_the_makers_software_connects_and_moves_an_axis_to_another_address(rig):
    """It believes to be connected when Address comes back with the number that it gave.

    Firmware 0.6.11 and later keep that number; what keeps none is lost again at once.
    """
    bus = open_socketcan("vcan0", 1_000_000)

    async def connect(found):
        device = found[SERIALS["q2"]]
        await asyncio.wait_for(device.connect(node_id=MOVED), PATIENCE)
        moved = await asyncio.to_thread(hears, bus, MOVED << 5 | 0x01)
        connected = device.connecting_or_connected
        device.disconnect()
        return connected, moved

    try:
        assert run(connect) == (True, True)
    finally:
        bus.shutdown()
