"""Every marker camera keeps the same contract: emulated, without images, and a real process."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from drivers.marker_camera.device import MarkerCameraDriver
from drivers.marker_camera.settings import (
    IntrinsicsSettings,
    MarkerCameraSettings,
    MarkerSettings,
    SourceSettings,
)
from drivers.sim.camera.settings import CameraSimulationSettings
from drivers.sim.camera.wiring import emulate_marker_camera, simulate_marker_camera
from drivers.sim.clock import SimClock
from drivers.sim.emulated_rig import EmulatedRig
from drivers.sim.wiring import Installed
from rig.hal import ConnectionFailed, DeviceFault, Markers, MonotonicClock, Reading, StaleReading

RECORDING = Path(__file__).parents[1] / "data" / "marker-circle.avi"
PERIOD = 1e-3
SETTINGS = MarkerCameraSettings(
    width=512, height=512, intrinsics=IntrinsicsSettings(cx=255.5, cy=255.5)
)
ARUCO = replace(SETTINGS, marker=MarkerSettings(kind="aruco", ids=(5,)))


class CirclingPlant:
    """A marker that draws a circle at 0.5 Hz and spins a little, as a function of time."""

    def __init__(self, optics=None):
        self.time = 0.0
        self.camera = optics or CameraSimulationSettings()

    def advance(self, t):
        self.time = max(self.time, t)

    def marker_position(self):
        return self.position_at(self.time)

    def ring_rotation(self):
        n = np.array(self.position_at(self.time)) / SETTINGS.marker.sphere_radius
        axis = np.cross([0, 0, 1], n)
        k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        swing = np.eye(3) + k + k @ k / (1 + n[2])
        twist = self.twist_at(self.time)
        c, s = math.cos(twist), math.sin(twist)
        return (swing @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]).tolist()

    @staticmethod
    def position_at(t):
        tilt, azimuth, h = math.radians(20.0), math.pi * t, SETTINGS.marker.sphere_radius
        return (
            h * math.sin(tilt) * math.cos(azimuth),
            h * math.sin(tilt) * math.sin(azimuth),
            h * math.cos(tilt),
        )

    @staticmethod
    def twist_at(t):
        return 0.1 * math.sin(2.0 * t)


class Scheduled(NamedTuple):
    at: float
    device: str
    fault: str
    size: float | None = None


class Simulation(NamedTuple):
    seed: int = 1
    bus_latency: float = 0.3e-3
    frame_loss: float = 0.0
    faults: tuple[Scheduled, ...] = ()


class Bench:
    """A camera of one kind on its plant, and a loop that takes its readings."""

    def __init__(self, kind, settings=SETTINGS, *, optics=None, seed=1, serial=None):
        self.plant = CirclingPlant(optics)
        self.log = []
        if kind == "process":
            self.clock = MonotonicClock()
            self.camera = MarkerCameraDriver(
                "camera", recorded(settings), self.clock, serial=serial
            )
        elif kind == "emulated":
            emulated = emulate_marker_camera(Installed("camera", settings, self.plant, seed=seed))
            rig = EmulatedRig(self.plant, (), Simulation(), cameras=[emulated])
            self.clock = SimClock(rig)
            self.camera = MarkerCameraDriver(
                "camera", settings, self.clock, serial=serial, link=emulated
            )
            self.inject, self.known_faults = partial(rig.inject, "camera"), emulated.known_faults
        else:
            self.clock = SimClock(self.plant)
            self.camera = simulate_marker_camera(
                Installed("camera", settings, self.plant, seed=seed), self.clock
            )
            self.inject, self.known_faults = self.camera.inject, self.camera.known_faults

    def start(self):
        self.camera.connect()
        self.camera.arm()
        return self

    def run(self, duration):
        """Cycle for a time: readings, then the check; every new reading goes to the log."""
        for _ in range(round(duration / PERIOD)):
            self.clock.sleep_until(self.clock.now() + PERIOD)
            reading = self.camera.markers()
            if not self.log or reading.t != self.log[-1][1].t:
                self.log.append((self.clock.now(), reading, self.camera.twists()))
            self.camera.check(self.clock.now())
        return self.log


def recorded(settings):
    return replace(
        settings,
        source=SourceSettings(kind="video", path=str(RECORDING), repeat=True),
        width=640,
        height=512,
        intrinsics=IntrinsicsSettings(fx=1666.0, fy=1666.0, cx=319.5, cy=255.5, k1=-0.05),
        connect_timeout=60.0,
        max_age=60.0,
    )


KINDS = ("process", "emulated", "simulated")
SIMULATED = ("emulated", "simulated")


@pytest.fixture
def bench():
    made = []

    def make(*arguments, **options):
        made.append(Bench(*arguments, **options))
        return made[-1]

    yield make
    for item in made:
        item.camera.close()


# Life cycle ---------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_before_it_is_connected_nothing_was_seen(bench, kind):
    camera = bench(kind).camera
    assert camera.markers() == Reading(Markers((), ()), -math.inf)
    assert camera.twists() == Reading((), -math.inf)
    camera.check(0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_armed_it_has_seen_the_marker(bench, kind):
    camera = bench(kind).start().camera
    reading = camera.markers()
    assert reading.value.ids == (0,)
    (position,) = reading.value.positions
    assert all(type(value) is float for value in position)
    assert math.hypot(*position) == pytest.approx(SETTINGS.marker.sphere_radius, rel=1e-12)
    assert math.hypot(*position[:2]) == pytest.approx(18e-3, abs=50e-6)
    assert len(camera.twists().value) == 1
    camera.check(camera.markers().t)


@pytest.mark.parametrize("kind", KINDS)
def test_it_can_be_closed_in_any_state_and_used_again(bench, kind):
    camera = bench(kind).camera
    camera.close()
    for _ in range(2):
        camera.connect()
        camera.arm()
        camera.make_safe()
        camera.close()
        camera.close()
        camera.make_safe()


@pytest.mark.parametrize("kind", KINDS)
def test_camera_of_another_rig_is_refused(bench, kind):
    settings = replace(SETTINGS, calibrated_serial="4711")
    item = bench(kind, settings, serial=4712)
    if kind == "simulated":  # has the serial number that the profile asks for
        item = bench(kind, settings)
        item.camera._serial = 4712
    with pytest.raises(ConnectionFailed, match="another camera") as caught:
        item.camera.connect()
    assert caught.value.bound == "4712"


# Readings -----------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "bound"), [("emulated", 2e-6), ("simulated", 40e-6)])
def test_reading_is_true_at_its_time_and_comes_after_its_latency(bench, kind, bound):
    item = bench(kind).start()
    log = item.run(0.5)
    assert len(log) in (30, 31)
    for now, reading, _ in log[1:]:
        (position,) = reading.value.positions
        assert math.dist(position, CirclingPlant.position_at(reading.t)) < bound
        assert SETTINGS.latency <= now - reading.t + 1e-9
        assert now - reading.t <= SETTINGS.latency + PERIOD + 1e-9


@pytest.mark.parametrize("kind", SIMULATED)
def test_square_marker_shows_twist(bench, kind):
    log = bench(kind, ARUCO).start().run(0.2)
    for _, reading, twists in log:
        assert reading.value.ids == (5,)
        assert twists.value[0] == pytest.approx(CirclingPlant.twist_at(reading.t), abs=5e-3)


@pytest.mark.parametrize("kind", SIMULATED)
def test_disc_does_not_show_twist(bench, kind):
    assert math.isnan(bench(kind).start().camera.twists().value[0])


@pytest.mark.parametrize("kind", SIMULATED)
def test_equal_seeds_give_equal_readings(bench, kind):
    optics = CameraSimulationSettings(drop_rate=0.2, latency_jitter=1e-3)
    logs = [
        [entry[:2] for entry in bench(kind, optics=optics, seed=seed).start().run(0.25)]
        for seed in (1, 1, 2)
    ]
    assert logs[0] == logs[1]
    assert logs[0] != logs[2]


@pytest.mark.parametrize("kind", SIMULATED)
def test_dropped_frames_give_no_readings(bench, kind):
    item = bench(kind, optics=CameraSimulationSettings(drop_rate=0.3), seed=3).start()
    log = item.run(0.5)
    assert 15 < len(log) < 28  # of 31


@pytest.mark.parametrize("kind", SIMULATED)
def test_wrong_latency_shifts_the_time_stamps(bench, kind):
    item = bench(kind, optics=CameraSimulationSettings(latency=45e-3)).start()
    for _, reading, _ in item.run(0.2):
        (position,) = reading.value.positions
        assert math.dist(position, CirclingPlant.position_at(reading.t - 5e-3)) < 40e-6
        assert math.dist(position, CirclingPlant.position_at(reading.t)) > 200e-6


# Faults -------------------------------------------------------------------------------

FAULTS = [
    ("unplugged", SETTINGS, DeviceFault, "camera: the camera stopped .* unplugged", 0.02),
    ("covered", SETTINGS, DeviceFault, "lens is covered or the lamp is off; .* mean", 0.32),
    ("lost", SETTINGS, DeviceFault, "marker is out of sight; .* 30 counts", 0.32),
    (
        "swapped",
        SETTINGS,
        DeviceFault,
        r"another disc .* 0.0036\d? m, bound 0.006 m",
        0.32,
    ),
    ("swapped", ARUCO, DeviceFault, "another marker .* number 6, bound number 5", 0.32),
    ("mirrored", ARUCO, DeviceFault, "mirrored.*number 5 mirrored", 0.32),
    ("frozen", SETTINGS, DeviceFault, "frozen; .* equal images", 0.16),
    ("stalled", SETTINGS, StaleReading, "camera: the last reading is 150.* ms old", 0.16),
    ("late", SETTINGS, StaleReading, "camera: the last reading is 150.* ms old", 0.16),
]


@pytest.mark.parametrize("kind", SIMULATED)
@pytest.mark.parametrize(
    ("fault", "settings", "error", "words", "within"),
    FAULTS,
    ids=[f"{fault}-{settings.marker.kind}" for fault, settings, *_ in FAULTS],
)
def test_fault_is_named_in_time(bench, kind, fault, settings, error, words, within):
    item = bench(kind, settings).start()
    item.run(0.1)
    assert fault in item.known_faults
    item.inject(fault, 0.3 if fault == "late" else None)
    since = item.clock.now()
    with pytest.raises(error, match=words):
        item.run(1.0)
    # Latency and one frame come on top of what the settings allow.
    assert item.clock.now() - since <= within + 0.002


@pytest.mark.parametrize("kind", SIMULATED)
@pytest.mark.parametrize("fault", ["covered", "lost", "swapped", "stalled"])
def test_short_fault_passes(bench, kind, fault):
    item = bench(kind).start()
    item.inject(fault, 0.06)
    item.run(0.3)
    assert item.camera.markers().value.ids == (0,)


@pytest.mark.parametrize("kind", SIMULATED)
def test_marker_that_is_not_seen_is_absent_not_zero(bench, kind):
    item = bench(kind).start()
    item.inject("lost", 0.06)
    readings = [reading.value for _, reading, _ in item.run(0.2)]
    assert Markers((), ()) in readings


@pytest.mark.parametrize("kind", SIMULATED)
def test_mirrored_disc_is_seen_mirrored(bench, kind):
    # One disc looks the same in a mirror: only the encoders can tell.
    item = bench(kind).start()
    item.inject("mirrored")
    _, reading, _ = item.run(0.2)[-1]
    x, y, z = CirclingPlant.position_at(reading.t)
    assert reading.value.positions[0] == pytest.approx((-x, y, z), abs=60e-6)


@pytest.mark.parametrize("kind", SIMULATED)
def test_covered_lens_is_refused_before_anything_moves(bench, kind):
    item = bench(kind, replace(SETTINGS, connect_timeout=0.2))
    item.inject("covered")
    item.camera.connect()
    with pytest.raises(ConnectionFailed, match="lens is covered"):
        item.camera.arm()


@pytest.mark.parametrize("kind", SIMULATED)
def test_unplugged_camera_is_refused(bench, kind):
    item = bench(kind)
    item.inject("unplugged")
    with pytest.raises(ConnectionFailed, match="unplugged"):
        item.camera.connect()


@pytest.mark.parametrize("kind", SIMULATED)
def test_camera_without_frames_is_refused(bench, kind):
    item = bench(kind, replace(SETTINGS, connect_timeout=0.2))
    item.inject("stalled")
    item.camera.connect()
    with pytest.raises(ConnectionFailed, match="no frame came"):
        item.camera.arm()


@pytest.mark.parametrize("kind", SIMULATED)
def test_faults_that_make_no_sense_are_refused(bench, kind):
    item = bench(kind)
    with pytest.raises(ValueError, match="camera: no fault 'melted'; known are covered"):
        item.inject("melted")
    with pytest.raises(ValueError, match="camera: covered takes more than -1 s"):
        item.inject("covered", -1.0)


@pytest.mark.parametrize("kind", SIMULATED)
def test_repair_ends_faults(bench, kind):
    item = bench(kind).start()
    for fault in ("covered", "late"):
        item.inject(fault)
    item.inject("repair")
    item.run(0.4)
    assert item.camera.markers().value.ids == (0,)


# The world of `--on virtual` ----------------------------------------------------------


def test_faults_of_a_schedule_reach_a_camera_beside_emulated_buses():
    plant = CirclingPlant()
    emulated = emulate_marker_camera(Installed("camera", SETTINGS, plant, seed=1))
    simulation = Simulation(faults=(Scheduled(0.2, "camera", "lost", 0.06),))
    rig = EmulatedRig(plant, (), simulation, cameras=[emulated])
    clock = SimClock(rig)
    camera = MarkerCameraDriver("camera", SETTINGS, clock, link=emulated)
    camera.connect()
    camera.arm()
    absent = set()
    while clock.now() < 0.5:
        clock.sleep_until(clock.now() + PERIOD)
        reading = camera.markers()
        camera.check(clock.now())
        if not reading.value.ids:
            absent.add(reading.t)
    assert len(absent) in (3, 4)
    assert 0.19 < min(absent) < 0.22
    assert 0.24 < max(absent) < 0.27
    assert rig.time == pytest.approx(clock.now())


def test_two_cameras_look_at_one_plant():
    plant = CirclingPlant()
    fast = replace(SETTINGS, frame_rate=100.0)
    links = [
        emulate_marker_camera(Installed(name, fast, plant, seed=1)) for name in ("left", "right")
    ]
    clock = SimClock(EmulatedRig(plant, (), Simulation(), cameras=links))
    cameras = [MarkerCameraDriver(link.name, fast, clock, link=link) for link in links]
    for camera in cameras:
        camera.connect()
    for camera in cameras:
        camera.arm()
    readings = [camera.markers() for camera in cameras]
    for reading in readings:
        (position,) = reading.value.positions
        assert math.dist(position, CirclingPlant.position_at(reading.t)) < 2e-6
    assert readings[0] != readings[1]  # each has noise of its own
