"""What every device does, and every device of a capability, whatever is behind it.

A suite's subject is a device of a profile, on `sim` and on `virtual`; or whatever the fixture
``make_bench`` of a subclass makes.
"""

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar, Generic, TypeVar

import pytest

from rig.hal import (
    Device,
    DeviceFault,
    EmergencyStopInput,
    LinearEncoder,
    MarkerCamera,
    PressureRegulator,
    Reading,
    ServoBus,
    Vector,
)
from rig.hal.columns import schema_text
from rig.hal.offers import lacking
from rig.testing.bench import Bench, ProfileBench

Tested = TypeVar("Tested", bound=Device)

_LATEST = 2.5
"""Cycles: no fresh reading is older."""
_GROWN_OLD = 50e-3
"""A silent device that raises no fault has a reading that is older, s: a mechanism refuses it."""


class DeviceSuite(Generic[Tested]):
    """The life cycle of any device, and that its readings are fresh.

    Attributes
    ----------
    configs, rig, device : Path and str
        The folder of the configurations, the profile and its device.
    capability : type
        The protocol that it has to meet.
    silence : str
        The fault of its simulated forms that stops its readings.
    """

    configs: ClassVar[Path]
    rig: ClassVar[str]
    device: ClassVar[str]
    capability: ClassVar[type] = Device
    silence: ClassVar[str] = "silent"

    @pytest.fixture(params=["sim", "virtual"])
    def make_bench(self, request: pytest.FixtureRequest) -> Callable[[], Bench[Tested]]:
        """Return what makes a bench that nobody has touched."""
        return lambda: ProfileBench(self.configs, self.rig, self.device, request.param)

    @pytest.fixture
    def bench(self, make_bench: Callable[[], Bench[Tested]]) -> Bench[Tested]:
        """Return a bench whose device is armed and in the loop."""
        made = make_bench()
        made.start()
        return made

    def read_at(self, device: Tested) -> float | None:
        """Return of when the device's reading is, s; None: it has none."""
        return None

    def test_it_has_all_that_its_capability_asks_for(self, bench: Bench[Tested]) -> None:
        assert lacking(bench.device, self.capability) == ()

    def test_its_own_columns_have_a_value_each(self, bench: Bench[Tested]) -> None:
        columns = bench.device.log_columns
        values = bench.device.log_values()
        assert [type(value) for value in values] == [float] * len(columns)
        schema_text(columns)

    def test_readings_are_fresh_and_never_go_back(self, bench: Bench[Tested]) -> None:
        times = []
        for _ in range(20):
            bench.run(1)
            read_at = self.read_at(bench.device)
            if read_at is None:
                pytest.skip("it has no reading")
            times.append(read_at)
            assert 0.0 <= bench.clock.now() - read_at <= _LATEST * bench.period
        assert times == sorted(times)
        assert len(set(times)) == 20

    def test_silence_is_a_fault_or_the_reading_grows_old(self, bench: Bench[Tested]) -> None:
        bench.run(5)
        bench.inject(self.silence)
        name = bench.device.name
        with pytest.raises(DeviceFault, match=name):
            for _ in range(int(0.2 / bench.period)):
                bench.run(1)
                read_at = self.read_at(bench.device)
                if read_at is not None and bench.clock.now() - read_at > _GROWN_OLD:
                    raise DeviceFault(name, "grew old, which the mechanism refuses")

    def test_it_can_be_made_safe_and_closed_in_any_state_and_again(
        self, make_bench: Callable[[], Bench[Tested]]
    ) -> None:
        bench = make_bench()
        for _ in range(2):
            bench.device.make_safe()
            bench.device.close()
        bench = make_bench()
        bench.start()
        for _ in range(2):
            bench.device.make_safe()
            bench.device.close()
            bench.close()

    def test_a_second_start_after_a_stop(self, bench: Bench[Tested]) -> None:
        bench.safe_cycles(5)
        bench.restart()
        bench.run(20)


class PressureRegulatorSuite(DeviceSuite[PressureRegulator]):
    """Electro-pneumatic regulators.

    Attributes
    ----------
    settling : float
        After which a chamber has the pressure of its setpoint, s.
    tolerance : float
        Of a pressure that has settled, Pa; most regulators have a dead band.
    """

    capability = PressureRegulator
    settling: ClassVar[float] = 1.0
    tolerance: ClassVar[float] = 10e3

    def read_at(self, device: PressureRegulator) -> float:
        """Return of when the monitored pressures are."""
        return device.pressure().t

    def pressures(self, bench: Bench[PressureRegulator]) -> Vector:
        """Return what the chambers have; a bench that knows better may say the truth."""
        bench.device.check(bench.clock.now())  # which is when a device without a bus samples
        return bench.device.pressure().value

    def somewhere(self, device: PressureRegulator) -> Vector:
        """Return setpoints within the range, another one for each channel."""
        low, high = device.pressure_range
        count = len(device.channels)
        return tuple(low + (0.25 + 0.5 * k / count) * (high - low) for k in range(count))

    def hold(self, bench: Bench[PressureRegulator], wanted: Vector) -> None:
        """Give the same setpoints until they have settled."""
        cycles = round(self.settling / bench.period)
        bench.run(cycles, lambda: bench.device.set_pressure(wanted))

    def test_names_range_and_shapes(self, bench: Bench[PressureRegulator]) -> None:
        device = bench.device
        low, high = device.pressure_range
        assert low < high
        reading = device.pressure()
        assert isinstance(reading, Reading)
        assert [type(value) for value in reading.value] == [float] * len(device.channels)
        assert len(device.safe_pressure()) == len(device.channels)

    def test_connecting_vents(self, make_bench: Callable[[], Bench[PressureRegulator]]) -> None:
        bench = make_bench()
        bench.open()
        bench.clock.sleep_until(bench.clock.now() + self.settling)
        assert self.pressures(bench) == pytest.approx(
            [0.0] * len(bench.device.channels), abs=self.tolerance
        )

    def test_setpoints_before_arming_are_ignored(
        self, make_bench: Callable[[], Bench[PressureRegulator]]
    ) -> None:
        bench = make_bench()
        bench.open()
        bench.device.set_pressure(self.somewhere(bench.device))
        bench.clock.sleep_until(bench.clock.now() + 0.1)
        assert self.pressures(bench) == pytest.approx(
            [0.0] * len(bench.device.channels), abs=self.tolerance
        )

    def test_setpoints_are_followed_each_by_its_channel(
        self, bench: Bench[PressureRegulator]
    ) -> None:
        wanted = self.somewhere(bench.device)
        self.hold(bench, wanted)
        assert self.pressures(bench) == pytest.approx(wanted, abs=self.tolerance)
        assert bench.device.pressure().value == pytest.approx(wanted, abs=self.tolerance)

    def test_make_safe_vents_and_lasts(self, bench: Bench[PressureRegulator]) -> None:
        self.hold(bench, self.somewhere(bench.device))
        bench.safe_cycles(5)
        bench.device.set_pressure(self.somewhere(bench.device))
        bench.safe_cycles(round(2.0 * self.settling / bench.period))
        assert self.pressures(bench) == pytest.approx(
            bench.device.safe_pressure(), abs=self.tolerance
        )

    def test_setpoints_are_followed_after_a_second_start(
        self, bench: Bench[PressureRegulator]
    ) -> None:
        bench.safe_cycles(5)
        bench.restart()
        wanted = self.somewhere(bench.device)
        self.hold(bench, wanted)
        assert self.pressures(bench) == pytest.approx(wanted, abs=self.tolerance)


class LinearEncoderSuite(DeviceSuite[LinearEncoder]):
    """Linear encoders."""

    capability = LinearEncoder

    def read_at(self, device: LinearEncoder) -> float:
        """Return of when the positions are."""
        return device.position().t

    def test_names_stroke_and_shapes(self, bench: Bench[LinearEncoder]) -> None:
        device = bench.device
        for reading in (device.position(), device.velocity()):
            assert isinstance(reading, Reading)
            assert [type(value) for value in reading.value] == [float] * len(device.channels)
        assert all(0.0 <= extension <= device.stroke for extension in device.position().value)


class ServoBusSuite(DeviceSuite[ServoBus]):
    """Chains of servo drives.

    Attributes
    ----------
    speed : float
        At which an axis is moved, rad/s.
    tolerance : float
        How far an axis may be from where it was sent once it stands, rad.
    enabling : float
        How long the drives may take until they follow, s.
    """

    capability = ServoBus
    speed: ClassVar[float] = 0.4
    tolerance: ClassVar[float] = 5e-3
    enabling: ClassVar[float] = 0.5

    def read_at(self, device: ServoBus) -> float:
        """Return of when the positions are."""
        return device.positions().t

    def move(self, bench: Bench[ServoBus], angle: float) -> Vector:
        """Move every axis by an angle, wait, and return where each was sent."""
        device = bench.device
        bench.run(round(self.enabling / bench.period))
        targets = list(device.positions().value)
        step = self.speed * bench.period
        cycles = round(angle / step)

        def follow() -> None:
            device.command_positions(tuple(targets))

        for _ in range(cycles):
            for k in range(len(targets)):
                targets[k] += step
            bench.run(1, follow)
        bench.run(round(self.enabling / bench.period), follow)
        return tuple(targets)

    def test_names_and_shapes(self, bench: Bench[ServoBus]) -> None:
        device = bench.device
        for reading in (device.positions(), device.velocities()):
            assert isinstance(reading, Reading)
            assert [type(value) for value in reading.value] == [float] * len(device.axis_names)

    def test_arming_moves_nothing(self, make_bench: Callable[[], Bench[ServoBus]]) -> None:
        bench = make_bench()
        bench.start()
        before = bench.device.positions().value
        bench.run(round(self.enabling / bench.period))
        assert bench.device.positions().value == pytest.approx(before, abs=self.tolerance)

    def test_positions_are_followed(self, bench: Bench[ServoBus]) -> None:
        targets = self.move(bench, 0.1)
        assert bench.device.positions().value == pytest.approx(targets, abs=self.tolerance)

    def test_made_safe_it_stands_still_whatever_is_sent(self, bench: Bench[ServoBus]) -> None:
        self.move(bench, 0.05)
        bench.safe_cycles(round(self.enabling / bench.period))
        before = bench.device.positions().value
        bench.device.command_positions(tuple(angle + 0.05 for angle in before))
        bench.safe_cycles(round(self.enabling / bench.period))
        assert bench.device.positions().value == pytest.approx(before, abs=self.tolerance)


class MarkerCameraSuite(DeviceSuite[MarkerCamera]):
    """Cameras with a marker detector; they are slower than the loop, and late.

    Attributes
    ----------
    looking : float
        How long the camera is looked at, s.
    """

    capability = MarkerCamera
    silence = "unplugged"
    looking: ClassVar[float] = 0.3

    def read_at(self, device: MarkerCamera) -> float:
        """Return of when the markers were seen."""
        return device.markers().t

    def test_readings_are_fresh_and_never_go_back(self, bench: Bench[MarkerCamera]) -> None:
        times = []
        for _ in range(round(self.looking / bench.period)):
            bench.run(1)
            times.append(bench.device.markers().t)
            assert times[-1] <= bench.clock.now()
        assert times == sorted(times)
        assert len(set(times)) > 3

    def test_every_marker_has_a_place(self, bench: Bench[MarkerCamera]) -> None:
        bench.run(round(self.looking / bench.period), bench.device.markers)
        markers = bench.device.markers().value
        assert len(markers.positions) == len(markers.ids) > 0
        assert len(markers.twists) in (0, len(markers.ids))
        for position in markers.positions:
            assert [type(coordinate) for coordinate in position] == [float] * 3


class EmergencyStopSuite:
    """The contact of an emergency stop, on a device whose suite stands beside this one.

    Its simulated forms know the fault ``emergency_stop``.
    """

    def stop_of(self, bench: Bench[Device]) -> EmergencyStopInput:
        """Return the device as what reads the contact."""
        assert lacking(bench.device, EmergencyStopInput) == ()
        return bench.device  # type: ignore[return-value]

    def test_the_emergency_stop_is_read(self, bench: Bench[Device]) -> None:
        stop = self.stop_of(bench)
        assert stop.emergency_stop().value is False
        assert stop.was_pressed() is False
        bench.inject("emergency_stop", 1.0)
        bench.run(3)
        assert stop.emergency_stop().value is True
        bench.inject("emergency_stop", 0.0)
        bench.run(3)
        assert stop.emergency_stop().value is False
        assert stop.was_pressed() is True, "released again, and not forgotten"
