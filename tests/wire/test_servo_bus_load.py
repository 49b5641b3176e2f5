"""How full servo drives make a bus: six of them on 1 Mbit/s, and where that ends."""

import pytest

from drivers.can.load import check_bus_load, compute_bus_load
from drivers.canopen.settings import CanBusSettings
from drivers.cia402.settings import Cia402Settings, DriveSettings
from drivers.odrive.settings import OdriveAxisSettings, OdriveBusSettings, OdriveSettings
from rig.hal import ConfigurationError

CAN = CanBusSettings("socketcan", "can0")


def cia402(**changes):
    joints = {f"q{k}": DriveSettings(node=k, counts_per_turn=4096.0) for k in range(1, 7)}
    return Cia402Settings(joints=joints, **changes)


def test_six_drives_at_200_hz_fill_half_of_a_bus():
    load = compute_bus_load(CAN, [("arm", cia402())], 200.0)
    # per drive: 7 bytes there and back (125 bits), 8 bytes of feedback (135 bits); a SYNC of
    # 55 bits; 7 heartbeats of 65 bits at 20 Hz
    expected = (200 * (6 * (125 + 125 + 135) + 55) + 20 * 7 * 65) / 1e6
    assert load.total == pytest.approx(expected)
    assert expected == pytest.approx(0.482, abs=1e-3)
    assert sum("heartbeat" in frame.name for frame in load.frames) == 7


def test_without_feedback_a_third_is_enough():
    assert compute_bus_load(CAN, [("arm", cia402(feedback=()))], 200.0).total < 0.33


def test_at_400_hz_they_are_refused_with_what_fills_the_bus():
    with pytest.raises(ConfigurationError, match=r"bus can0.*400 Hz.*9\d\.\d %") as caught:
        check_bus_load("can0", CAN, [("arm", cia402())], 400.0)
    assert "arm q3 TPDO2 state" in str(caught.value)
    assert "arm q3 RPDO1 setpoint" in str(caught.value)


def odrive(**changes):
    joints = {f"q{k}": OdriveAxisSettings(axis=k) for k in range(1, 7)}
    return OdriveSettings(joints=joints, **changes)


def test_odrives_send_by_their_own_clocks():
    bus = OdriveBusSettings("socketcan", "can0")
    load = compute_bus_load(bus, [("arm", odrive())], 200.0)
    # per axis: setpoints and estimates at 200 Hz, heartbeats at 50 Hz, all of 8 bytes
    assert load.total == pytest.approx(6 * 135 * (200 + 200 + 50) / 1e6)
    assert load.total == pytest.approx(0.365, abs=1e-3)
    names = {frame.name for frame in load.frames}
    assert "arm q2 Set_Input_Pos" in names
    assert "arm q2 Get_Encoder_Estimates" in names
    assert not any("master" in name or name == "SYNC" for name in names)
    faster = compute_bus_load(bus, [("arm", odrive(encoder_period=0.001))], 200.0)
    assert faster.total - load.total == pytest.approx(6 * 135 * 800 / 1e6)


def test_odrives_that_send_too_often_are_refused():
    bus = OdriveBusSettings("socketcan", "can0", bitrate=500_000)
    with pytest.raises(ConfigurationError, match=r"bus can0.*200 Hz and 500000 bit/s is 72\.9 %"):
        check_bus_load("can0", bus, [("arm", odrive())], 200.0)
