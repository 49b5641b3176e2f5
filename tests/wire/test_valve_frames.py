"""The frames of proportional valves on a CiA 401 module, byte by byte."""

import pytest
from cia401_bench import VENTED, AnalogueBench

from drivers.cia401.channel_settings import MonitorSignal, OpeningSignal, ValveChannel
from drivers.cia401.valve_settings import Cia401ValvesSettings
from drivers.cia401.valves import Cia401Valves
from rig.hal import DeviceFault, LimitExceeded

MIDDLE = "201#0040004001"  # 16384 counts, 5 V, and the supply open


def channel(sub, **setpoint):
    return ValveChannel(
        OpeningSignal(sub=sub, voltage=(0.0, 10.0), **setpoint),
        MonitorSignal(sub=sub, raw=(3000.0, 15000.0), voltage=(1.0, 5.0), pressure=(0.0, 900e3)),
    )


SETTINGS = Cia401ValvesSettings(
    node=1, channels={"agonist": channel(1), "antagonist": channel(2)}, supply_bit=0, stop_bit=0
)


class Valves(AnalogueBench):
    def __init__(self, settings=SETTINGS):
        super().__init__(Cia401Valves, settings)

    def run(self, *frames, opening=None):
        self.interface.put(*frames)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.check(now)
        if opening is None:
            self.driver.make_safe()
        else:
            self.driver.set_opening(opening)
        self.bus.transmit(now)
        self.clock.sleep_until(now + 0.002)
        return [frame for frame in self.sent() if frame.startswith("201")]


@pytest.fixture
def valves():
    bench = Valves()
    bench.start()
    return bench


def test_the_start_has_the_module_exhaust_whenever_it_loses_its_master():
    bench = Valves(
        Cia401ValvesSettings(
            node=1,
            # A plumbing in which 10 V exhausts: the counts of the exhaust are not 0.
            channels={"a": channel(1, opening=(1.0, -1.0)), "b": channel(2)},
            supply_bit=0,
        )
    )
    bench.driver.connect()
    writes = bench.sent()
    for frame in (
        "601#2F43640101000000",  # error mode: take the error value
        "601#23446401FF7F0000",  # which is 0x7FFF, the exhaust
        "601#2344640200000000",  # and 0 for the other
        "601#2F066201FF000000",  # digital outputs: error value
        "601#2F07620100000000",  # which shuts the supply
        "601#2B116401FF7F0000",  # and both stand there from the start
        "601#2B11640200000000",
        "601#2F00620100000000",
    ):
        assert frame in writes
    assert bench.node.objects[0x6444, 1] == (0x7FFF).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("opening", "data"),
    [
        ((0.0, 0.0), "0040004001"),  # 16383.5 rounds half to even
        ((1.0, -1.0), "FF7F000001"),
        ((0.5, -0.5), "FF5F002001"),  # 24575.25 and 8191.75
        ((0.01, -0.02), "A340B83E01"),  # 16547.3 and 16055.8
    ],
)
def test_openings_are_counts_of_0_to_10_volt(valves, opening, data):
    assert valves.run(VENTED, opening=opening) == [f"201#{data}"]


def test_safe_is_the_exhaust_with_the_supply_shut(valves):
    assert valves.run(VENTED, opening=(0.0, 0.0)) == [MIDDLE]
    assert valves.run(VENTED) == ["201#0000000000"]
    assert valves.run(VENTED, opening=(0.3, 0.3)) == ["201#0000000000"]  # until it is armed again


def test_it_is_safe_when_its_own_sensors_say_that_the_chambers_are_empty(valves):
    valves.run("181#9828100E01", opening=(0.0, 0.0))
    valves.run("181#9828100E01")
    told = valves.driver.unsafe(valves.clock.now())
    assert "valves: agonist still holds 554.4 kPa, antagonist still holds 45.0 kPa" in told
    valves.run(VENTED)
    valves.run(VENTED)
    assert valves.driver.unsafe(valves.clock.now()) == ""


@pytest.mark.parametrize("bad", [(1.01, 0.0), (0.0, -1.01), (float("nan"), 0.0)])
def test_an_opening_beyond_the_stroke_is_refused_and_changes_nothing(valves, bad):
    valves.run(VENTED, opening=(0.0, 0.0))
    with pytest.raises(LimitExceeded, match="valves: setpoint of"):
        valves.driver.set_opening(bad)
    assert valves.driver.log_values() == (0.0, 0.0)


def test_a_sensor_without_its_live_zero_is_a_broken_wire(valves):
    with pytest.raises(DeviceFault, match=r"monitor of antagonist has a broken wire.*0x6401"):
        for _ in range(4):
            valves.run("181#B80B000001", opening=(0.0, 0.0))


def test_a_signal_that_cannot_exhaust_is_refused():
    with pytest.raises(ValueError, match=r"a\.setpoint\.opening: 0 … 1 does not reach -1"):
        Cia401ValvesSettings(node=1, channels={"a": channel(1, opening=(0.0, 1.0))})
    with pytest.raises(ValueError, match=r"a\.setpoint\.opening: it ends at 0\.02.*be filled"):
        Cia401ValvesSettings(node=1, channels={"a": channel(1, opening=(-1.0, 0.02))})
