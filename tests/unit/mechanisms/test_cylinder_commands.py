"""What a pair of cylinders may be told, what it is told at its stop, and how near a limit is."""

import pytest
from pneumatic_fakes import (
    AGE,
    BASE,
    HIGHEST,
    HOME,
    LOWEST,
    MISMATCH,
    PERIOD,
    REACH,
    FakeRegulators,
    HoldingRegulators,
    PairBench,
    pair_limits,
    pair_settings,
)

from controllers.cylinder.pid import Pid
from controllers.cylinder.types import PairCommand, PairReference, PairState
from rig.hal import ConfigurationError
from rig.hal.quantities import Margin
from rig.mechanisms.cylinder import mechanism
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.mechanisms.cylinder.references import PairMotion

REST = PairState(0.0, 0.0, BASE, BASE)


class Held(PairMotion):
    """A reference that stays at one place, and steps aside at one tick of the loop's."""

    duration = 4 * PERIOD
    segments = ()

    def __init__(self, position, at_tick=0):
        self.position = position
        self.at_tick = at_tick

    def at(self, t):
        return PairReference(self.position if t >= self.at_tick * PERIOD else 0.0, 0.0, 0.0)


def limited(command, **limits):
    """Return what is applied, and how often what was hit; started from the base pressure."""
    bench = PairBench(pair_settings(pair_limits(**limits)))
    bench.pair.start_limiting(REST)
    return bench.pair.limit(PairCommand(*command)), bench.pair.limit_hits()


@pytest.mark.parametrize("sign", [1, -1])
def test_the_force_of_the_pair_is_kept_by_moving_both_pressures_alike(sign):
    area = pair_settings().area
    limits = {"pair_force": 100e3 * area}
    most = limits["pair_force"] / area
    low, high = 150e3, 150e3 + most
    command = (high, low) if sign > 0 else (low, high)
    assert limited(command, **limits) == (
        command,
        {"pressure range": 0, "pressure rate": 0, "pair force": 0},
    )
    wide = (high + 1.0, low - 1.0) if sign > 0 else (low - 1.0, high + 1.0)
    applied, hits = limited(wide, **limits)
    assert applied == pytest.approx(command, abs=1e-6)
    assert hits == {"pressure range": 0, "pressure rate": 0, "pair force": 1}


def test_range_and_rate_come_after_the_force():
    applied, hits = limited((600e3, 590e3))
    assert applied == (HIGHEST, HIGHEST)
    assert hits == {"pressure range": 2, "pressure rate": 0, "pair force": 0}
    applied, hits = limited((BASE + 3e3, BASE - 1e3), pressure_rate=2e3 / PERIOD)
    assert applied == (BASE + 2e3, BASE - 1e3)
    assert hits == {"pressure range": 0, "pressure rate": 1, "pair force": 0}


def test_the_rate_starts_from_the_measured_pressures():
    bench = PairBench(pair_settings(pair_limits(pressure_rate=1e3 / PERIOD)))
    bench.pair.start_limiting(PairState(0.0, 0.0, 200e3, 300e3))
    assert bench.pair.limit(PairCommand(250e3, 250e3)) == (201e3, 299e3)


@pytest.mark.parametrize(
    ("measured", "command"),
    [
        ((LOWEST, HIGHEST), (LOWEST, HIGHEST)),
        ((LOWEST - 1.0, HIGHEST + 1.0), (LOWEST, HIGHEST)),
        ((HIGHEST + 1.0, LOWEST - 1.0), (HIGHEST, LOWEST)),
        ((200e3, 300e3), (200e3, 300e3)),
    ],
)
def test_resting_keeps_what_is_measured_within_what_is_permitted(measured, command):
    assert PairBench().pair.resting_command(PairState(0.0, 0.0, *measured)) == command


def test_energised_both_chambers_have_the_base_pressure():
    assert PairBench().pair.energised_command(REST) == (BASE, BASE)


def test_released_both_chambers_have_the_least_pressure_but_what_the_devices_hold():
    assert PairBench().pair.released_command() == (LOWEST, LOWEST)
    regulators = HoldingRegulators(("agonist", "antagonist"))
    regulators.held = (0.0, 123e3)
    assert PairBench(regulators=regulators).pair.released_command() == (0.0, 123e3)


def test_a_blend_goes_from_its_start_to_its_end():
    start, end = PairCommand(100e3, 300e3), PairCommand(200e3, 100e3)
    blend = PairBench().pair.blend
    assert (blend(start, end, 0.0), blend(start, end, 1.0)) == (start, end)
    assert blend(start, end, 0.25) == (125e3, 250e3)


def test_what_is_applied_is_what_the_regulators_get():
    bench = PairBench()
    bench.pair.write(PairCommand(1e5, 2e5))
    assert bench.regulators.sent == [(1e5, 2e5)]


def test_the_row_has_a_value_for_each_column():
    bench = PairBench()
    bench.place(-0.25 * HOME, 0.25 * HOME)
    bench.regulators.reads = (11e3, 22e3)
    bench.regulators.t = bench.agonist.t = bench.antagonist.t = bench.stop.t = 1.0 - 0.5 * AGE
    state = bench.cycle(1.0, fresh=False)
    row = bench.pair.row(state, PairReference(1, 2, 3), PairCommand(4, 5), PairCommand(6, 7))
    named = dict(zip([column.name for column in bench.pair.columns], row, strict=True))
    assert named == {
        "reference.position": 1,
        "reference.velocity": 2,
        "reference.acceleration": 3,
        "reading.position": 0.25 * HOME,
        "reading.position_agonist": 0.75 * HOME,
        "reading.position_antagonist": 1.25 * HOME,
        "reading.pressure_agonist": 11e3,
        "reading.pressure_antagonist": 22e3,
        "reading.age": 0.5 * AGE,
        "estimate.velocity": 0.0,
        "estimate.disturbance": 0.0,
        "command.agonist": 4,
        "command.antagonist": 5,
        "applied.agonist": 6,
        "applied.antagonist": 7,
    }
    assert bench.pair.reference_of(state) == (0.25 * HOME, 0.0, 0.0)


@pytest.mark.parametrize(
    ("place", "late", "applied", "nearest"),
    [
        ((-0.75 * REACH, 0.75 * REACH), 0.0, 0.0, Margin("position", 0.25)),
        ((0.75 * REACH, -0.75 * REACH), 0.0, 0.0, Margin("position", 0.25)),
        ((0.0, 0.0), 0.875 * AGE, 0.0, Margin("reading age", 0.125)),
        ((0.0, 0.0), 0.0, 0.5 * HIGHEST, Margin("pressure", 0.5)),
        ((0.5 * MISMATCH, MISMATCH), 0.0, 0.0, Margin("rod mismatch", 0.25)),
        ((-0.5 * MISMATCH, -MISMATCH), 0.0, 0.0, Margin("rod mismatch", 0.25)),
    ],
)
def test_the_nearest_limit_is_told(place, late, applied, nearest):
    bench = PairBench()
    bench.place(*place)
    bench.regulators.t = bench.agonist.t = bench.antagonist.t = 1.0 - late
    state = bench.pair.read(1.0)
    for both in ((applied, 0.0), (0.0, applied)):
        assert bench.pair.worst_margin(state, PairCommand(*both), 1.0) == nearest


def test_the_middle_of_a_lopsided_range_is_furthest_from_its_limits():
    bench = PairBench(pair_settings(pair_limits(position=(-0.25 * REACH, 0.75 * REACH))))
    bench.move_to(0.625 * REACH)
    state = bench.pair.read(0.0)
    assert bench.pair.worst_margin(state, PairCommand(0.0, 0.0), 0.0) == ("position", 0.25)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_reference_may_reach_the_permitted_positions_and_not_pass_them(sign):
    def plan(motion):
        return AntagonisticPair.plan(pair_settings(), motion, None, PERIOD)

    inside = Held(sign * REACH)
    assert plan(inside) is inside
    with pytest.raises(ValueError, match=r"outside limits\.position, -15\.62 … 15\.62 mm"):
        plan(Held(sign * REACH * 1.0001))
    with pytest.raises(ValueError, match=r"after 0\.00391 s .* at -?16\.4\d* mm"):
        plan(Held(sign * REACH * 1.05, at_tick=4))  # the last one
    plan(Held(sign * REACH * 1.05, at_tick=5))  # when it has ended


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("after", [0.0, 0.382])  # at a tick of the loop, and between two
def test_a_reference_may_reach_the_permitted_speed_and_not_pass_it(sign, after):
    settings = pair_settings()

    class Passing(Held):
        def __init__(self, speed):
            super().__init__(0.0)
            self.speed = sign * speed

        def at(self, t):
            return PairReference(0.0, self.speed if t >= after * PERIOD else 0.0, 0.0)

    within = Passing(settings.limits.speed)
    assert AntagonisticPair.plan(settings, within, None, PERIOD) is within
    with pytest.raises(ValueError, match=r"after \d\S* s .* moves at -?\d.* m/s, faster"):
        AntagonisticPair.plan(settings, Passing(1.0001 * settings.limits.speed), None, PERIOD)


@pytest.mark.parametrize("tick", [0, 7, 14])
def test_a_speed_between_two_ticks_is_told_at_every_seventh(tick):
    settings = pair_settings()
    looked = []

    class Between(Held):
        duration = 15 * PERIOD

        def at(self, t):
            looked.append(t)
            aside = 0.3 * PERIOD < t - tick * PERIOD < 0.7 * PERIOD
            return PairReference(0.0, 2.0 * settings.limits.speed if aside else 0.0, 0.0)

    with pytest.raises(ValueError, match=r"faster than limits\.speed"):
        AntagonisticPair.plan(settings, Between(0.0), None, PERIOD)
    between = [t for t in looked if t % PERIOD]
    assert (len(between), len(looked)) == (tick // 7 + 1, tick + 1 + tick // 7 + 1)


class Moving(Held):
    """A reference that goes on at a speed, and jumps at one tick of the loop's."""

    def __init__(self, position, at_tick=0, speed=0.0):
        super().__init__(position, at_tick)
        self.speed = speed

    def at(self, t):
        jumped, _, _ = super().at(t)
        return PairReference(jumped + self.speed * t, self.speed, 0.0)


@pytest.fixture
def jumps(monkeypatch):
    """What is asked of each jump."""
    asked = []
    monkeypatch.setattr(mechanism, "check_jump", lambda *told: asked.append(told))
    return asked


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("speed", [0.0, 0.4, -0.4])
def test_a_jump_farther_than_is_followed_is_tried_with_the_pairs_law(sign, speed, jumps):
    """However far the speed carries it in a cycle: here the window is a tenth of that."""
    law = object.__new__(Pid)
    settings = pair_settings(pair_limits(following=0.04 * PERIOD))
    jump = sign * 0.05 * PERIOD
    AntagonisticPair.plan(settings, Moving(jump, 2, speed), law, PERIOD)
    assert len(jumps) == 1
    told, at, size, following, most, lost = jumps[0]
    assert (told, at) == (law, 2 * PERIOD)
    assert size == pytest.approx(jump)
    assert (following, most) == (settings.limits.following, settings.limits.pair_force)
    assert lost == settings.alarms.oscillation.lost


def test_no_jump_is_one_that_is_followed_that_begins_a_motion_or_that_is_no_pairs_laws(jumps):
    settings, law = pair_settings(pair_limits(following=1e-3)), object.__new__(Pid)
    AntagonisticPair.plan(settings, Moving(1e-3, 2), law, PERIOD)
    AntagonisticPair.plan(settings, Moving(5e-3, 0), law, PERIOD)
    AntagonisticPair.plan(settings, Moving(5e-3, 2), None, PERIOD)
    assert jumps == []


def test_what_is_no_reference_for_a_pair_is_refused():
    class Other:
        duration, segments = 1.0, ()

        def at(self, t):
            return (0.0,)

    with pytest.raises(ValueError, match="not one for a pair of cylinders"):
        AntagonisticPair.plan(pair_settings(), Other(), None, PERIOD)


def test_an_approach_goes_from_rest_to_rest():
    start, end = PairReference(0.0, 1.0, 1.0), PairReference(0.01, 1.0, 1.0)
    assert AntagonisticPair.approach(start, end, 2.0, 0.0) == (0.0, 0.0, 0.0)
    position, speed, _ = AntagonisticPair.approach(start, end, 2.0, 1.0)
    assert (position, speed) == pytest.approx((0.005, 1.875 * 0.01 / 2.0))
    assert AntagonisticPair.approach(start, end, 2.0, 2.0) == pytest.approx((0.01, 0.0, 0.0))


def test_controllers_are_told_what_the_profile_says():
    settings = pair_settings()
    model = AntagonisticPair.model_of(settings)
    assert (model.pressure_min, model.pressure_max) == (LOWEST, HIGHEST)
    assert (model.area, model.mass, model.base_pressure) == (settings.area, 0.14, BASE)
    assert (model.regulator_bandwidth, model.regulator_damping) == (40.0, 1.0)
    assert (model.coulomb, model.breakaway) == (10.0, 13.0)
    assert (model.stribeck_velocity, model.viscous) == (8e-3, 50.0)
    assert AntagonisticPair.wiring(settings) == {
        "encoder-agonist": "agonist",
        "encoder-antagonist": "antagonist",
    }


def test_a_pair_is_put_together_from_the_devices_that_the_profile_names():
    bench = PairBench()
    devices = {
        "regulators": bench.regulators,
        "encoder-agonist": bench.agonist,
        "encoder-antagonist": bench.antagonist,
        "stop": bench.stop,
    }
    with_stop = pair_settings(emergency_stop="stop")
    pair = AntagonisticPair.assemble(with_stop, devices, PERIOD)
    bench.place(-0.5 * HOME, 0.0)
    assert pair.read(0.0).position == 0.25 * HOME
    with pytest.raises(
        ConfigurationError, match=r"cylinder\.emergency_stop: encoder-agonist is no"
    ):
        AntagonisticPair.assemble(pair_settings(emergency_stop="encoder-agonist"), devices, PERIOD)
    with pytest.raises(ConfigurationError, match=r"cylinder\.regulators: no device is called"):
        AntagonisticPair.assemble(pair_settings(regulators="valves"), devices, PERIOD)


def test_no_setpoint_lies_beyond_what_calibrated_regulators_can_give():
    """They begin at 2.5 kPa where the profile permits 0: venting must not be refused as 0."""
    regulators = FakeRegulators(("agonist", "antagonist"), pressure_range=(2.5e3, 495e3))
    bench = PairBench(pair_settings(pair_limits(pressure=(0.0, 500e3), pair_force=1e6)), regulators)
    bench.pair.start_limiting(bench.pair.read(0.0))
    assert bench.pair.limit(PairCommand(0.0, 500e3)) == (2.5e3, 495e3)
