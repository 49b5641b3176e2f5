"""Our emulated ODrives under the maker's own software: found, addressed, connected, configured.

Once it is connected, libodrive reads and writes parameters by RxSdo with the connection's number
in the first byte and a sequence number in the fourth, where the "CAN Protocol" of the manual has
opcode 0 or 1 and a reserved byte. That is nowhere published: what libodrive takes for an answer was
seen on the bus, and the emulated axis keeps to it (``tests/contract/test_odrive_connection.py``).
So these tests show that the maker's software works on it and that both ways lead to the same
parameters, not that a real ODrive sends the same bytes; our driver keeps to the manual.
"""

import asyncio
import os
import select
import struct
import time
from pathlib import Path

import pytest
from two_processes import PATIENCE, set_all, simulate

pytestmark = pytest.mark.vcan
try:
    import odrive.legacy_config
    import odrive.utils
    from odrive.device_manager import close_device_manager, get_device_manager
    from odrive.libodrive import Device, DeviceType
except (ImportError, OSError) as reason:  # OSError: its own library lacks another
    pytest.skip(f"the package odrive cannot be used here: {reason}", allow_module_level=True)

from drivers.can.socketcan import open_socketcan  # noqa: E402

SERIALS = {f"q{k}": 0x3A0000000000 + k for k in range(1, 7)}
ENDPOINTS = {
    "enable_watchdog": 300,
    "watchdog_timeout": 301,
    "heartbeat_period": 400,
    "encoder_period": 401,
}
MOVED = 0x20
RX_SDO, TX_SDO = 0x04, 0x05


@pytest.fixture(autouse=True)
def paced():
    """Have the time of our programs pass no faster than the maker's, see `patient_time`."""
    folder = os.environ.get("SHARED_TIME")
    if folder is None:
        yield
        return
    from shared_time import PACED  # where there is such a time, its modules are on the path

    file = Path(folder, PACED)
    file.touch()
    yield
    file.unlink()


@pytest.fixture
def rig():
    settings = {f"devices__drives__joints__{joint}__serial": n for joint, n in SERIALS.items()}
    # What our driver could write by these is as the maker ships it.
    settings |= {f"devices__drives__endpoints__{name}": n for name, n in ENDPOINTS.items()}
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
        select.select([bus.fileno()], [], [], 1.0)
        if any(received == can_id for received, _ in bus.drain()):
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


CONFIGURATION = {
    "axis0.config.enable_watchdog": True,
    "axis0.config.watchdog_timeout": 0.0625,
    "axis0.config.can.heartbeat_msg_rate_ms": 20,
    "axis0.config.can.encoder_msg_rate_ms": 5,
}


def read_by_manual(bus, node, endpoint, layout):
    """Return a parameter, asked for as the manual says."""
    bus.send_data(node << 5 | RX_SDO, struct.pack("<BHB4x", 0, endpoint, 0))
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        select.select([bus.fileno()], [], [], 1.0)
        for can_id, data in bus.drain():
            if can_id == node << 5 | TX_SDO and struct.unpack_from("<BH", data) == (0, endpoint):
                return struct.unpack_from(f"<{layout}", data, 4)[0]
    raise AssertionError(f"node {node} does not tell endpoint {endpoint}")


def test_the_makers_software_configures_an_axis(rig, tmp_path, monkeypatch, record_property):
    """As `odrivetool restore-config` does: written, verified, saved, and there after the reboot.

    With what our driver asks of an axis, under the numbers that the profile gives.
    """
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # where it keeps descriptions
    bus = open_socketcan("vcan0", 1_000_000)

    async def configure(found):
        manager = get_device_manager()
        device = await asyncio.wait_for(manager.use_connection(found[SERIALS["q3"]]), PATIENCE)
        assert (device.board, device.fw_version) == ((4, 4, 58), (0, 6, 11))
        before = await device.read_multiple(list(CONFIGURATION))
        await odrive.legacy_config.apply_config(
            device, CONFIGURATION, throw_on_error=True, verify=True
        )
        saved = await asyncio.wait_for(
            odrive.utils.call_rebooting_function(device, "save_configuration"), PATIENCE
        )
        after = await saved.read_multiple(list(CONFIGURATION))
        numbers = [saved.properties[path].endpoint_id for path in CONFIGURATION]
        assert numbers == list(ENDPOINTS.values())
        shown = [
            await asyncio.to_thread(read_by_manual, bus, saved.effective_node_id, number, layout)
            for number, layout in zip(numbers, "?fII", strict=True)
        ]
        return list(before), list(after), shown

    try:
        before, after, shown = run(configure)
    finally:
        bus.shutdown()
    wanted = list(CONFIGURATION.values())
    assert before == [False, 0.0, 100, 10]
    assert after == shown == wanted
    record_property("exchanges", ("parameters by the maker's odrive on vcan", 4 * len(wanted)))
