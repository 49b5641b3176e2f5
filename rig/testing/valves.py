"""What every device with proportional valves does; see `rig.testing.devices`."""

from collections.abc import Callable
from typing import ClassVar

import pytest

from rig.hal import ProportionalValves, Reading, Vector
from rig.testing.bench import Bench
from rig.testing.devices import DeviceSuite


class ProportionalValvesSuite(DeviceSuite[ProportionalValves]):
    """Proportional valves with a pressure sensor at each chamber.

    Attributes
    ----------
    opening : float
        That feeds and exhausts for certain, whatever a valve's dead zone.
    filling : float
        After which it has changed a chamber's pressure by ten times `tolerance`, s.
    tolerance : float
        Of an empty chamber's sensor, Pa.
    """

    capability = ProportionalValves
    opening: ClassVar[float] = 0.1
    filling: ClassVar[float] = 0.1
    tolerance: ClassVar[float] = 5e3

    def read_at(self, device: ProportionalValves) -> float:
        """Return of when the pressures are."""
        return device.pressure().t

    def give(self, bench: Bench[ProportionalValves], opening: Vector) -> Vector:
        """Give openings for a while, and return the pressures then."""
        cycles = round(self.filling / bench.period)
        bench.run(cycles, lambda: bench.device.set_opening(opening))
        return bench.device.pressure().value

    def test_names_range_and_shapes(self, bench: Bench[ProportionalValves]) -> None:
        low, high = bench.device.sensor_range
        assert low < high
        reading = bench.device.pressure()
        assert isinstance(reading, Reading)
        assert [type(value) for value in reading.value] == [float] * len(bench.device.channels)

    def test_openings_before_arming_are_ignored(
        self, make_bench: Callable[[], Bench[ProportionalValves]]
    ) -> None:
        bench = make_bench()
        bench.open()
        bench.device.set_opening((1.0,) * len(bench.device.channels))
        bench.clock.sleep_until(bench.clock.now() + self.filling)
        bench.device.check(bench.clock.now())
        assert bench.device.pressure().value == pytest.approx(
            [0.0] * len(bench.device.channels), abs=self.tolerance
        )

    def test_each_valve_feeds_and_exhausts_its_own_chamber(
        self, bench: Bench[ProportionalValves]
    ) -> None:
        count = len(bench.device.channels)
        for mine in range(count):
            before = self.give(bench, (-1.0,) * count)
            fed = tuple(self.opening if k == mine else -1.0 for k in range(count))
            after = self.give(bench, fed)
            for k in range(count):
                rise = after[k] - before[k]
                assert (rise > 10.0 * self.tolerance) is (k == mine)

    def test_make_safe_exhausts_and_is_seen_to(self, bench: Bench[ProportionalValves]) -> None:
        count = len(bench.device.channels)
        self.give(bench, (self.opening,) * count)
        assert bench.device.unsafe(bench.clock.now()) != ""
        bench.safe_cycles(round(2.0 * self.filling / bench.period))
        bench.device.set_opening((1.0,) * count)
        bench.safe_cycles(round(2.0 * self.filling / bench.period))
        bench.device.check(bench.clock.now())
        assert bench.device.unsafe(bench.clock.now()) == ""
