"""Frames of load cells and inclinometers: what their bytes mean, and what is a fault."""

import math

import pytest
from scripted_bus import Bench, ScriptedNode, common_objects, u16

from drivers.cia410.device import Cia410Sensor
from drivers.cia410.settings import AxisObject, Cia410Settings
from drivers.load_cells.codec import cell_codec, decode_force
from drivers.load_cells.device import CanopenLoadCells
from drivers.load_cells.settings import LoadCell, LoadCellSettings
from rig.hal import ConnectionFailed, DeviceFault

BOTH_WAYS = LoadCell(sub=1, force=(-100.0, 100.0))
FOUR_TO_TWENTY = LoadCell(sub=2, raw=(6554.0, 32767.0), force=(0.0, 50.0))
PULLED = LoadCell(sub=3, force=(40.0, -40.0), zero=1.5)


@pytest.mark.parametrize(
    ("cell", "counts", "force"),
    [
        (BOTH_WAYS, 0, 0.0),
        (BOTH_WAYS, 16000, 50.0),
        (BOTH_WAYS, -32000, -100.0),
        (FOUR_TO_TWENTY, 6554, 0.0),
        (FOUR_TO_TWENTY, 32767, 50.0),
        (PULLED, -32000, 38.5),
        (PULLED, 0, -1.5),
    ],
)
def test_counts_of_a_cell_are_these_forces(cell, counts, force):
    assert decode_force(cell_codec(cell), counts) == pytest.approx(force, abs=1e-9)


class SeveralPdos(ScriptedNode):
    """A node that answers one SYNC by all that it has to send."""

    def receive(self, can_id, data):
        if can_id == 0x80:
            self.bus.put(*self.sync_answers)
            self.sync_answers.clear()
        else:
            super().receive(can_id, data)


class Device(Bench):
    """A driver whose node is written down."""

    def start(self, first):
        self.driver.connect()
        self.node.sync_answers += first
        self.driver.arm()
        self.clock.sleep_until(self.clock.now() + 0.001)
        self.sent()
        return self

    def run(self, *frames):
        self.interface.put(*frames)
        now = self.clock.now()
        self.bus.receive(now)
        self.driver.check(now)
        self.bus.transmit(now)
        self.clock.sleep_until(now + 0.005)


class Cells(Device):
    first = ("181#803EC0E0B80B48F4", "281#0100")

    def __init__(self, **settings):
        super().__init__()
        self.node = SeveralPdos(self.interface, 1, common_objects(0x00000191))
        cells = {f"c{sub}": LoadCell(sub=sub, force=(-100.0, 100.0)) for sub in range(1, 6)}
        self.driver = CanopenLoadCells(
            "feet", LoadCellSettings(**{"node": 1, "cells": cells} | settings), self.bus
        )


def test_forces_of_two_pdos_are_one_reading():
    feet = Cells().start(Cells.first)
    t = feet.clock.now()
    feet.run()
    feet.run("181#803EC0E0B80B48F4", "281#0200")
    forces, at = feet.driver.forces()
    assert forces == pytest.approx((50.0, -25.0, 9.375, -9.375, 0.00625))
    assert at == t
    assert feet.driver.channels == ("c1", "c2", "c3", "c4", "c5")


def test_half_a_sample_is_none():
    feet = Cells(fault_after=3, frozen_timeout=None).start(Cells.first)
    before = feet.driver.forces()
    with pytest.raises(DeviceFault, match="feet"):
        for _ in range(6):
            feet.run("181#0000000000000000")
    assert feet.driver.forces().t == before.t


def test_a_cell_at_its_end_for_long_is_named_and_a_peak_is_not():
    feet = Cells(overload_after=3).start(Cells.first)
    feet.run()
    for number in range(2):
        feet.run("181#007D000000000000", f"281#{number:02X}00")
    feet.run("181#0000000000000000", "281#0300")
    with pytest.raises(DeviceFault, match=r"feet: c1 is at the end of its range.*32000 counts"):
        for number in range(4):
            feet.run("181#007D000000000000", f"281#{number:02X}00")


def test_frozen_cells_are_a_fault_in_time():
    feet = Cells(frozen_timeout=0.1).start(Cells.first)
    feet.run()
    began = feet.clock.now()
    with pytest.raises(DeviceFault, match=r"feet: its readings are frozen.*bound 0.1 s"):
        for _ in range(100):
            feet.run(*Cells.first)
    assert 0.09 < feet.clock.now() - began < 0.12


def test_settings_of_cells_name_what_is_wrong():
    twice = {"a": LoadCell(sub=1, force=(0.0, 1.0)), "b": LoadCell(sub=1, force=(0.0, 1.0))}
    with pytest.raises(ValueError, match="two of them are on one object"):
        LoadCellSettings(node=1, cells=twice)
    with pytest.raises(ValueError, match=r"force: 3 … 3 N is no line"):
        LoadCell(sub=1, force=(3.0, 3.0))
    with pytest.raises(ValueError, match="raw: 5 … 1 does not rise"):
        LoadCell(sub=1, raw=(5.0, 1.0), force=(0.0, 1.0))
    with pytest.raises(ValueError, match="does not fit into i8"):
        LoadCell(sub=1, type="i8", force=(0.0, 1.0))


class Lean(Device):
    """A DIS QG65D: 0.01 degrees, and 0.01 degrees a second."""

    first = ("182#0000000000000000",)

    def __init__(self, resolution=10, **settings):
        super().__init__()
        objects = common_objects(0x0002019A)
        if resolution is not None:
            objects |= {(0x6000, 0): u16(resolution)}
        self.node = ScriptedNode(self.interface, 2, objects)
        self.driver = Cia410Sensor("waist", Cia410Settings(**{"node": 2} | settings), self.bus)


@pytest.mark.parametrize(
    ("settings", "frame", "lean", "turning"),
    [
        ({}, "182#64009CFF10270000", (1.0, -1.0), (100.0, 0.0)),
        ({}, "182#9411000000009CFF", (45.0, 0.0), (0.0, -1.0)),
        (
            {"roll": AxisObject(0x6010, reversed=True), "pitch_zero": math.radians(0.5)},
            "182#6400640000006400",
            (-1.0, 0.5),
            (0.0, 1.0),
        ),
    ],
)
def test_lean_and_rates_are_decoded(settings, frame, lean, turning):
    waist = Lean(**settings).start(Lean.first)
    t = waist.clock.now()
    waist.run()
    waist.run(frame)
    value, at = waist.driver.lean()
    assert at == t
    assert [math.degrees(angle) for angle in value] == pytest.approx(lean)
    assert [math.degrees(rate) for rate in waist.driver.turning().value] == pytest.approx(turning)


def test_another_resolution_is_refused_and_none_is_believed():
    with pytest.raises(ConnectionFailed, match=r"another step.*0x6000:00"):
        Lean(resolution=100).driver.connect()
    Lean(resolution=None).driver.connect()


def test_a_frozen_sensor_is_a_fault():
    waist = Lean(frozen_timeout=0.05).start(Lean.first)
    with pytest.raises(DeviceFault, match="waist: its readings are frozen"):
        for _ in range(30):
            waist.run("182#6400640000006400")


def test_two_quantities_on_one_object_are_refused():
    with pytest.raises(ValueError, match="two of them are on one object"):
        Cia410Settings(node=2, pitch=AxisObject(0x6010))
