"""What is refused before an ODrive moves: settings, and axes that are not as they should be."""

import pytest
from odrive_bench import PERIOD, Bench, joint
from scripted_bus import ScriptedBus, TestClock

from drivers.odrive.bus import OdriveBus
from drivers.odrive.device import OdriveServos
from drivers.odrive.settings import OdriveBusSettings, OdriveEndpoints, OdriveSettings
from rig.hal import ConnectionFailed, DeviceFault

# Settings --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: OdriveSettings(joints={"a": joint(), "b": joint()}), "joints a and b.*axis 3"),
        (
            lambda: OdriveSettings(joints={"a": joint(gear=100.0, max_speed=3.0)}),
            r"feedforward of 47\.\d+ turn/s does not fit",
        ),
        (lambda: joint(limits=(1.0, 0.0)), "limits: the lower limit 1 is not below"),
    ],
)
def test_settings_that_cannot_be_right_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"watchdog": 0.01, "period": 0.01}, "watchdog.*two periods"),
        ({"encoder_period": 0.01}, "encoder_period.*longer than the cycle"),
        ({"period": None}, "no period"),
    ],
)
def test_a_cycle_that_does_not_fit_is_refused(changes, message):
    period = changes.pop("period", PERIOD)
    bus = OdriveBus("can0", OdriveBusSettings("x", "y"), ScriptedBus, TestClock(), period)
    with pytest.raises(ValueError, match=message):
        OdriveServos("arm", OdriveSettings(joints={"a": joint()}, **changes), bus)


# Axes ------------------------------------------------------------------------------------


def test_nobody_there():
    bench = Bench()
    bench.clock.axis = None
    with pytest.raises(ConnectionFailed, match=r"joint elbow \(node 0x03\).*no heartbeat"):
        bench.connect()


def test_old_firmware_is_refused_with_a_sentence():
    bench = Bench()
    bench.axis.version = (2, 3, 6, 56, 0, 5, 6, 0)
    with pytest.raises(ConnectionFailed, match=r"other things.*firmware 0\.5\.6.*0\.6 or later"):
        bench.connect()
    bench.axis.version = None
    with pytest.raises(ConnectionFailed, match=r"does not say its version.*update it"):
        bench.connect()


def test_serial_numbers_are_compared_and_doubles_found():
    Bench(axis={"serial": 0xABCDEF}).connect()
    with pytest.raises(ConnectionFailed, match=r"serial number.*000000ABCDEF.*000000000001"):
        Bench(axis={"serial": 1}).connect()
    bench = Bench()
    bench.axis.serials.append(0x77)
    with pytest.raises(ConnectionFailed, match="2 ODrives have this node number"):
        bench.connect()


def test_errors_before_use_are_refused_in_words_but_not_an_expired_watchdog():
    bench = Bench()
    bench.axis.errors = 0x4000000
    with pytest.raises(ConnectionFailed, match=r"reports an error.*spinout.*remove the cause"):
        bench.connect()
    bench.driver.reset_fault()
    bench.connect()
    bench = Bench()
    bench.axis.errors = 0x1000000
    frames = bench.start()
    assert "078#00" in frames, "a new run begins with clearing what ended the last one"


def test_errors_that_stay_are_named():
    bench = Bench()
    bench.axis.errors, bench.axis.obeys = 0x100, False
    bench.clock.sleep_until(bench.clock.now() + PERIOD)
    with pytest.raises(ConnectionFailed, match=r"errors stay: over-voltage of the DC bus"):
        bench.driver.reset_fault()


def test_a_parameter_that_is_not_kept_is_refused():
    bench = Bench(endpoints=OdriveEndpoints(enable_watchdog=7, watchdog_timeout=8))
    keep = bench.axis.receive

    def forget(can_id, data):
        if can_id != 0x064 or data[0] != 1:
            keep(can_id, data)

    bench.axis.receive = forget
    with pytest.raises(ConnectionFailed, match=r"reads back another.*endpoint 8 \(watchdog_tim"):
        bench.connect()


def test_estimates_that_come_too_seldom_are_refused():
    bench = Bench()
    talk = bench.axis.talk
    bench.axis.talk = lambda: talk() if round(bench.clock.time / PERIOD) % 4 == 0 else None
    with pytest.raises(ConnectionFailed, match=r"estimates come too seldom.*one in 0.005 s"):
        bench.connect()


def test_an_axis_that_does_not_go_idle_or_close_its_loop_is_named():
    bench = Bench(enable_time=0.2)
    bench.axis.obeys = False
    bench.axis.state = 8
    with pytest.raises(ConnectionFailed, match=r"CLOSED LOOP CONTROL.*bound IDLE"):
        bench.connect()
    bench.axis.state = 1
    with pytest.raises(DeviceFault, match=r"does not close its loop.*axis state 1 \(IDLE\)"):
        bench.start()


def test_a_joint_outside_its_limits_is_not_energised():
    bench = Bench()
    bench.axis.turns = 2.5
    with pytest.raises(ConnectionFailed, match=r"outside its limits.*2.5 rad.*-1 … 2 rad"):
        bench.start()
