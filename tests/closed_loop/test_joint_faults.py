"""What breaks on the joint is named within the time that the profile states, and it ends safe."""

import numpy as np
import pytest
from joint_fault_bench import AT, run
from scipy.signal import lsim, lti

from rig.assembly import Backend

CYCLES = 0.01
"""A few cycles until a reading shows it and a check looks, s."""


def plant(fault, channel=None):
    return [(AT, "plant", fault, channel)]


def device(name, fault, value=None):
    return [(AT, name, fault, value)]


def swapped(one, other):
    """Encoders that are mounted on each other's rods from the start."""
    return [
        (0, f"encoder-{one}", "other_rod", other - 1),
        (0, f"encoder-{other}", "other_rod", one - 1),
    ]


GRACE = 0.05  # limits.grace
PRESSURE = 0.05  # alarms.pressure.time, after the deviation has grown beyond its bound
ABSENCE = 0.25  # max_absence of the camera, after the last frame that showed the marker
AGE = 0.15  # max_age of the camera
FRAME = 1 / 60 + 0.04  # until the next frame is there
ENERGISED = 1.0

FAULTS = {
    "wire-cut": (plant("wire_cut", 0), 0.02, ("wire of ch1", "slack or cut", "mm")),
    "wire-slack": (plant("wire_slack", 1), 0.02, ("wire of ch2", "slack or cut", "mm")),
    "anchor-slipped": (
        plant("anchor_slipped", 2),
        GRACE + CYCLES,
        ("ch3", "anchor", "mm", "0.5 mm for 0.05 s"),
    ),
    "regulator-open": (
        plant("regulator_open", 0),
        PRESSURE,  # or sooner: its rod runs away
        ("regulators: the regulator of ch1 is stuck open", "regulator, even of a late one, for"),
    ),
    "regulator-closed": (
        plant("regulator_closed", 1),
        PRESSURE + 0.25,  # its setpoint must first ask for another pressure, see below
        ("regulators: the regulator of ch2 is stuck closed", "kPa off what is usual, at most"),
    ),
    "supply-lost": (
        plant("supply_lost"),
        PRESSURE + 0.05,
        ("regulators: the supply pressure is lost", "fall short", "kPa off "),
    ),
    "encoder-frozen": (
        device("encoder-2", "frozen"),
        0.25,  # until the others have moved on by the distance, over the bus 0.2 s
        ("encoder-2 is frozen", "rod of ch2 is jammed", "0.4 mm for 0.05 s"),
    ),
    "encoder-jumped": (device("encoder-2", "jump"), CYCLES, ("encoder-2", "jumped", "0.001")),
    "camera-unplugged": (device("camera", "unplugged"), FRAME, ("camera", "unplugged")),
    "lens-covered": (
        device("camera", "covered"),
        ABSENCE + FRAME,
        ("camera", "lens is covered", "counts", "0.25 s"),
    ),
    "marker-swapped": (
        device("camera", "swapped"),
        ABSENCE + FRAME,
        ("camera", "another disc than the marker", "0.006 m", "0.25 s"),
    ),
    "marker-mirrored": (
        device("camera", "mirrored"),
        GRACE + 2 * FRAME,
        ("camera", "image is mirrored left to right", "mm", "3 mm for 0.05 s"),
    ),
    "frames-late": (device("camera", "late"), AGE + FRAME, ("camera", "ms old", "150.0 ms")),
    "image-frozen": (device("camera", "frozen"), 0.15, ("camera", "image is frozen", "5")),
}
FROM_THE_START = {
    "encoders-1-3-swapped": (
        swapped(1, 3),
        (),
        (ENERGISED, 1.5),
        ("encoder-1 and encoder-3 are swapped", "tubes of ch1 and ch3", "against their pull", "mJ"),
    ),
    "encoders-2-4-swapped": (
        swapped(2, 4),
        (),
        (ENERGISED, 1.5),
        ("encoder-2 and encoder-4 are swapped", "tubes of ch2 and ch4", "mJ"),
    ),
    "encoders-1-2-swapped": (
        swapped(1, 2),
        (),
        (ENERGISED, 1.5),
        ("encoder-1 and encoder-2 are swapped",),
    ),
    "encoders-3-4-swapped": (
        swapped(3, 4),
        (),
        (ENERGISED, 1.5),
        ("encoder-3 and encoder-4 are swapped",),
    ),
    "calibration-of-another-rig": (
        [],
        ("plant.camera.rotation_error=[0.05, 0, 0]",),
        (GRACE, GRACE + 2 * FRAME),
        ("camera", "before anything has moved", "another rig's calibration", "mm", "3 mm"),
    ),
    "ring-twisted": (
        [],
        ("devices.camera.marker.kind=aruco", "plant.camera.rotation_error=[0, 0, 0.3]"),
        (0.1, 0.1 + 2 * FRAME),
        ("camera", "twisted", "+17.", "10 deg"),
    ),
}


LIKE_ANOTHER = ("encoder-jumped", "image-frozen", "encoders-2-4-swapped", "encoders-3-4-swapped")


def quick(table):
    """Return a table's rows as parameters, those much like another only for the long test run."""
    return [
        pytest.param(*row, id=name, marks=[pytest.mark.slow] if name in LIKE_ANOTHER else [])
        for name, row in table.items()
    ]


def assert_stopped_safe(found, words):
    result, log, events, _ = found
    assert (result.exit_code, result.status.value) == (4, "faulted")
    for word in words:
        assert word in result.message
    assert [event for event in events if event["message"] == result.message]
    # Complete up to the cycle that saw it, which was recorded with what was sent then: vent.
    assert log.cycle[-1] == len(log.cycle) - 1
    assert [log.column(f"applied.ch{k}")[-1] for k in (1, 2, 3, 4)] == [0.0] * 4


@pytest.mark.parametrize(("faults", "within", "words"), quick(FAULTS))
def test_fault_is_named_in_time(tmp_path, faults, within, words):
    found = run(tmp_path, Backend.SIM, faults)
    assert_stopped_safe(found, words)
    assert 0.0 <= found.after <= within


@pytest.mark.parametrize(("faults", "more", "between", "words"), quick(FROM_THE_START))
def test_what_was_wrong_from_the_start_is_named(tmp_path, faults, more, between, words):
    found = run(tmp_path, Backend.SIM, faults, more)
    assert_stopped_safe(found, words)
    early, late = between
    assert early <= found.after <= late


@pytest.mark.slow
@pytest.mark.parametrize(("faults", "within", "words"), FAULTS.values(), ids=FAULTS)
def test_fault_is_named_in_time_over_the_bus(tmp_path, faults, within, words):
    found = run(tmp_path, Backend.VIRTUAL, faults)
    assert_stopped_safe(found, words)
    assert 0.0 <= found.after <= within


@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "more", "between", "words"), FROM_THE_START.values(), ids=FROM_THE_START
)
def test_what_was_wrong_from_the_start_is_named_over_the_bus(
    tmp_path, faults, more, between, words
):
    found = run(tmp_path, Backend.VIRTUAL, faults, more)
    assert_stopped_safe(found, words)
    early, late = between
    assert early <= found.after <= late


def test_a_stuck_regulator_is_named_as_soon_as_it_has_been_off_for_long_enough(tmp_path):
    log = run(tmp_path, Backend.SIM, plant("regulator_closed", 1)).log
    t, pressure = log.t, log.column("reading.pressure_ch2")
    # A healthy regulator as the profile has it: 41.7 rad/s, damping 1.03.
    healthy = lti([41.7**2], [1.0, 2.0 * 1.03 * 41.7, 41.7**2])
    setpoint = log.column("applied.ch2") - pressure[0]
    _, expected, _ = lsim(healthy, setpoint, t - t[0], interp=False)
    well = np.abs(pressure - pressure[0] - expected) <= 40e3
    well_at = t[np.flatnonzero(well)]
    assert t[-1] - well_at[-1] <= PRESSURE + CYCLES
    assert np.diff(well_at[well_at > 0.5]).max() <= PRESSURE + CYCLES


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("channel", [0, 1, 2, 3])
def test_the_wire_of_an_anchor_that_slips_is_among_those_named(tmp_path, channel, seed):
    more = (f"simulation.seed={seed}",)
    found = run(tmp_path, Backend.SIM, plant("anchor_slipped", channel), more)
    assert_stopped_safe(found, (f"ch{channel + 1}", "anchor"))
    assert 0.0 <= found.after <= GRACE + CYCLES


def test_camera_that_was_not_calibrated_is_never_used(tmp_path):
    more = (
        "devices.camera.serial=42",
        "devices.camera.calibrated_serial='41'",
    )
    found = run(tmp_path, Backend.VIRTUAL, [], more)
    assert found.result.exit_code == 3
    for word in ("camera", "another camera than the one that was calibrated", "42", "41"):
        assert word in found.result.message
    assert found.log is None
