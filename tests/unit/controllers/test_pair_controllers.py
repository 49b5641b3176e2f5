"""What all controllers of a pair have in common, and what each promises."""

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.compiled import record_type
from controllers.cylinder.cascade import Cascade
from controllers.cylinder.feedforward import Feedforward, FeedforwardSettings
from controllers.cylinder.pid import Pid
from controllers.cylinder.pid_friction import PidFriction
from controllers.cylinder.super_twisting import SuperTwisting
from controllers.cylinder.types import PairReference, PairState

PERIOD = 1e-3
ALL = [Pid, PidFriction, Cascade, SuperTwisting]

every = pytest.mark.parametrize("kind", ALL, ids=lambda kind: kind.__name__)


def build(kind, model, **changes):
    return kind(replace(kind.Settings(), **changes), model, PERIOD)


def undithered(kind, model):
    changes = {"dither_amplitude": 0.0} if kind is PidFriction else {}
    return build(kind, model, **changes)


def wander(count):
    """Return states and references of some motion, and no more meaning than that."""
    for k in range(count):
        t = k * PERIOD
        position = 5e-3 * math.sin(3.0 * t)
        yield (
            PairState(t, position - 1e-4, 0.13e6 + 1e4 * math.sin(9.0 * t), 0.11e6),
            PairReference(position, 15e-3 * math.cos(3.0 * t), -45e-3 * math.sin(3.0 * t)),
        )


@every
def test_same_inputs_give_the_same_commands(kind, model):
    first, second = build(kind, model), build(kind, model)
    for controller in (first, second):
        controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
    assert [first.update(*step) for step in wander(300)] == [
        second.update(*step) for step in wander(300)
    ]


@every
def test_reset_forgets_everything(kind, model):
    used, fresh = build(kind, model), build(kind, model)
    for step in wander(300):
        used.update(*step)
    for controller in (used, fresh):
        controller.reset(PairState(0.0, 1e-3, 0.13e6, 0.11e6))
    assert [used.update(*step) for step in wander(50)] == [
        fresh.update(*step) for step in wander(50)
    ]


@every
@given(
    agonist=st.floats(40e3, 200e3),
    antagonist=st.floats(40e3, 200e3),
    position=st.floats(-10e-3, 10e-3),
    error=st.floats(-1e-3, 1e-3),
    velocity=st.floats(-30e-3, 30e-3),
)
def test_first_command_is_the_measured_differential(
    kind, model_once, agonist, antagonist, position, error, velocity
):
    controller = undithered(kind, model_once)
    state = PairState(0.0, position, agonist, antagonist)
    controller.reset(state)
    command = controller.update(state, PairReference(position + error, velocity, 0.0))
    assert command.agonist - command.antagonist == pytest.approx(agonist - antagonist, abs=1.0)
    assert command.agonist + command.antagonist == pytest.approx(0.24e6)


@pytest.fixture(scope="module")
def model_once():
    from controllers.cylinder.types import PairModel

    return PairModel(1.8e-4, 0.138, 0.12e6, 0.0, 0.5e6, 40.0, 1.0, 6.5, 6.7, 3e-3, 30.0)


@every
@given(st.lists(st.tuples(st.floats(-30e-3, 30e-3), st.floats(-30e-3, 30e-3)), max_size=30))
def test_commands_are_finite_and_never_leave_the_range(kind, model_once, jumps):
    controller = build(kind, model_once)
    floor = controller.settings.pressure_floor
    top = 2 * model_once.base_pressure - floor
    controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
    for k, (position, reference) in enumerate(jumps):
        for _ in range(5):
            command = controller.update(
                PairState(k * PERIOD, position, 0.12e6, 0.12e6), PairReference(reference, 0.0, 0.0)
            )
            assert all(floor - 1e-6 <= pressure <= top + 1e-6 for pressure in command)
            assert all(type(pressure) is float for pressure in command)


@every
def test_saturation_does_not_wind_up(kind, model):
    """After 5 s against a jammed load the command turns round as after 0.5 s."""
    turned = []
    for jammed in (0.5, 5.0):
        controller = build(kind, model)
        state = PairState(0.0, 0.0, 0.12e6, 0.12e6)
        controller.reset(state)
        for _ in range(round(jammed / PERIOD)):
            command = controller.update(state, PairReference(20e-3, 0.0, 0.0))
        assert command.agonist - command.antagonist > 150e3
        cycles = 0
        while command.agonist > command.antagonist:
            command = controller.update(state, PairReference(-20e-3, 0.0, 0.0))
            cycles += 1
            assert cycles < 1000
        turned.append(cycles)
    assert turned[1] <= turned[0] + 1


@every
def test_the_estimate_follows_a_steady_motion(kind, model):
    controller = build(kind, model)
    controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
    for k in range(200):
        position = 10e-3 * k * PERIOD
        controller.update(
            PairState(k * PERIOD, position, 0.12e6, 0.12e6), PairReference(position, 10e-3, 0.0)
        )
    assert controller.estimate.velocity == pytest.approx(10e-3, rel=0.02)


def test_cascade_predicts_over_the_delay_that_it_is_told(model):
    """On a ramp read one period late, the right delay leaves no position error to act on."""
    first = []
    for delay in (0.0, PERIOD):
        controller = build(
            Cascade,
            model,
            delay=delay,
            integral=1e6,
            trim_rate=0.0,
            disturbance_gain=0.0,
            feedforward=FeedforwardSettings(learning_rate=0.0),
        )

        controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
        for k in range(300):
            t = k * PERIOD
            late = 10e-3 * (t - PERIOD)
            command = controller.update(
                PairState(t, late, 0.12e6, 0.12e6), PairReference(10e-3 * t, 10e-3, 0.0)
            )
        later = controller.update(
            PairState(t, late + 10e-3 * PERIOD, 0.12e6, 0.12e6),
            PairReference(10e-3 * (t + PERIOD), 10e-3, 0.0),
        )
        first.append((later.agonist - command.agonist) / PERIOD)
    drift, steady = first
    # An error of 10 µm over an integral of 1e6 N/(m s) is 10 N/s, shared by two chambers.
    assert drift == pytest.approx(0.5 * 10.0 / model.area, rel=0.02)
    assert abs(steady) < 0.01 * drift


def test_cascade_compensates_what_it_observes(model):
    """A push that no reference explains is met at once, before any position error."""
    commands = []
    for gain in (0.0, 1.0):
        controller = build(
            Cascade,
            model,
            disturbance_gain=gain,
            disturbance_bandwidth=100.0,
            integral=0.0,
            trim_rate=0.0,
            feedforward=FeedforwardSettings(gain=0.0),
        )
        still = PairState(0.0, 0.0, 0.12e6, 0.12e6)
        controller.reset(still)
        controller.update(still, PairReference(0.0, 0.0, 0.0))
        # The pressures pull with 1 N and nothing moves: something pushes back.
        pulled = PairState(0.0, 0.0, 0.12e6 + 1.0 / model.area, 0.12e6)
        for _ in range(100):
            command = controller.update(pulled, PairReference(0.0, 0.0, 0.0))
        commands.append((command.agonist - command.antagonist) * model.area)
    assert commands[0] == pytest.approx(0.0, abs=1e-6)
    assert commands[1] == pytest.approx(1.0, rel=0.01)


def test_cascade_holds_harder_once_the_pair_sticks(model):
    """At rest and stuck the force on an error grows by `hold_integral`, before by `integral`."""
    rates = []
    for hold in (1e5, 4e5):
        controller = build(
            Cascade,
            model,
            integral=1e5,
            hold_integral=hold,
            trim_rate=0.0,
            disturbance_gain=0.0,
            feedforward=FeedforwardSettings(gain=0.0),
        )
        stuck = PairState(0.0, 0.0, 0.12e6, 0.12e6)
        controller.reset(stuck)
        forces = []
        for _ in range(200):
            command = controller.update(stuck, PairReference(10e-6, 0.0, 0.0))
            forces.append((command.agonist - command.antagonist) * model.area)
        rates.append((forces[-1] - forces[-101]) / (100 * PERIOD))
    assert rates == pytest.approx([1.0, 4.0], rel=0.01)


def test_cascade_loads_a_pair_that_sticks_towards_its_reference(model):
    """Friction is fed forward within 20 ms, whichever way the pair came; not for a far step."""
    for error in (0.1e-3, -0.1e-3):
        controller = build(Cascade, model, integral=0.0, hold_integral=0.0, trim_rate=0.0,
                           disturbance_gain=0.0, position_rate=0.0,
                           feedforward=FeedforwardSettings(error_rate=2.0))  # fmt: skip
        stuck = PairState(0.0, 0.0, 0.12e6, 0.12e6)
        controller.reset(stuck)
        for _ in range(150):
            command = controller.update(stuck, PairReference(error, 0.0, 0.0))
        force = (command.agonist - command.antagonist) * model.area
        assert force == pytest.approx(math.copysign(model.coulomb, error), rel=0.1)
        controller.reset(stuck)
        for _ in range(150):
            command = controller.update(stuck, PairReference(50 * error, 0.0, 0.0))
        assert command.agonist == pytest.approx(command.antagonist, abs=100.0)


def test_dither_has_its_amplitude_and_frequency(model):
    controller = build(
        PidFriction,
        model,
        dither_amplitude=2e3,
        dither_frequency=25.0,
        integral=0.0,
        feedforward=FeedforwardSettings(gain=0.0),
    )
    state = PairState(0.0, 0.0, 0.12e6, 0.12e6)
    controller.reset(state)
    commands = [controller.update(state, PairReference(0.0, 0.0, 0.0)) for _ in range(400)]
    shaken = [command.agonist - command.antagonist for command in commands]
    assert max(shaken) == pytest.approx(2e3, rel=1e-3)
    rising = sum(a <= 0.0 < b for a, b in itertools.pairwise(shaken))
    assert rising == 10


@pytest.mark.parametrize("friction", ["smooth", "stribeck", "presliding"])
def test_feedforward_pushes_along_the_motion(model, friction):
    settings = FeedforwardSettings(friction=friction, gain=1.0)
    for sign in (1.0, -1.0):
        controller = build(
            Cascade, model, trim_rate=0.0, disturbance_gain=0.0, feedforward=settings
        )
        controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
        position = 0.0
        for k in range(300):
            position = sign * max(k - 100, 0) * 20e-3 * PERIOD
            velocity = sign * 20e-3 if k >= 100 else 0.0
            command = controller.update(
                PairState(k * PERIOD, position, 0.12e6, 0.12e6),
                PairReference(position + velocity * PERIOD, velocity, 0.0),
            )
        force = (command.agonist - command.antagonist) * model.area
        assert force == pytest.approx(sign * (6.5 + 30.0 * 20e-3), rel=0.15)


def test_cascade_trims_what_its_regulators_are_off_but_not_more(model):
    """Regulators that put out 4 kPa too little get 4 kPa more; a lost supply is not chased."""
    for off, expected in ((4e3, 4e3), (60e3, 15e3)):
        # Only the trim acts: the chambers below are quicker than any that the loops could face.
        controller = build(
            Cascade, model, velocity_rate=0.0, integral=0.0, disturbance_gain=0.0, trim_rate=5.0
        )
        state = PairState(0.0, 0.0, 0.12e6, 0.12e6)
        controller.reset(state)
        for k in range(2000):
            command = controller.update(state, PairReference(0.0, 0.0, 0.0))
            # Both chambers follow at once, only less.
            state = PairState(
                k * PERIOD, 0.0, command.agonist - 0.5 * off, command.antagonist + 0.5 * off
            )
        assert command.agonist - command.antagonist == pytest.approx(expected, rel=0.01)


def test_feedforward_learns_what_the_integral_holds_against_friction(model):
    """A unit with 1.5 times the friction, slid both ways under an ideal integral."""
    settings = FeedforwardSettings(friction="smooth", gain=1.0, learning_rate=5.0)
    feedforward = Feedforward(settings, model, PERIOD)
    integral = 0.0
    for k in range(4000):
        velocity = 5e-3 if k // 500 % 2 == 0 else -5e-3
        needed = 1.5 * math.copysign(6.5 + 30.0 * 5e-3, velocity)
        force = feedforward.update(velocity, 0.0, 0.0) + integral
        integral += 0.1 * (needed - force)
        before = feedforward.update(velocity, 0.0, 0.0) + integral
        integral -= feedforward.learn(integral)
        after = feedforward.update(velocity, 0.0, 0.0) + integral
        assert after == pytest.approx(before, abs=1e-9)
    assert feedforward.scale == pytest.approx(1.5, rel=0.02)
    assert abs(integral) < 0.1


def test_a_pair_at_rest_teaches_nothing_and_lessons_are_bounded(model):
    feedforward = Feedforward(FeedforwardSettings(gain=1.0, learning_rate=50.0), model, PERIOD)
    for _ in range(1000):
        feedforward.update(20e-3, 0.0, 0.0)
    feedforward.update(0.0, 0.0, 0.0)
    assert feedforward.learn(5.0) == 0.0
    for _ in range(10_000):
        feedforward.update(20e-3, 0.0, 0.0)
        feedforward.learn(1e3)
    assert feedforward.scale == 3.0


@every
def test_a_compiled_law_is_the_same_law_to_the_bit(kind, model):
    plain, compiled = build(kind, model), build(kind, model)
    compiled.compile()
    for start in (0.0, 1e-3):  # the second time from anew
        for controller in (plain, compiled):
            controller.reset(PairState(0.0, start, 120_000, 110_000))
        for state, reference in wander(2000):
            for load in (0.0, 3.0):
                assert compiled.update(state, reference, load) == plain.update(
                    state, reference, load
                )
                assert compiled.estimate == plain.estimate
                assert compiled.correction == plain.correction


def test_only_numbers_are_laid_out_for_a_kernel():
    class Named:
        def __init__(self):
            self.gain = 1.0
            self.name = "agonist"

    with pytest.raises(TypeError, match=r"Named\.name is 'agonist', which is no number"):
        record_type(Named())


@pytest.mark.parametrize(
    ("tuned", "share"), [(1.0, 1.0), (0.8, 1.25), (1.25, 0.8), (16.0, 0.5), (0.01, 2.0)]
)
def test_a_cascade_bears_more_gain_with_more_friction_than_it_was_tuned_with(model, tuned, share):
    """Its fourth root, of no less than half and no more than twice as much."""
    rate = share**0.25 * Cascade.Settings().velocity_rate
    follows = build(Cascade, model, tuned_viscous=tuned * model.viscous)
    told = build(Cascade, model, velocity_rate=rate)
    for controller in (follows, told):
        controller.reset(PairState(0.0, 0.0, 0.12e6, 0.12e6))
    for step in wander(50):
        assert follows.update(*step) == pytest.approx(told.update(*step))
