"""Figures that judge a motion say what is computed from the same data otherwise."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from rig.assembly import Backend
from rig.experiment.plan import load_plan
from rig.experiment.run import run_experiment
from rig.hal.motion import Segment
from rig.mechanisms.cylinder.frequency_figure import draw_pair_response
from rig.mechanisms.cylinder.step_figure import draw_steps
from rig.mechanisms.joint.figures.repeatability import draw_joint_repeatability
from rig.mechanisms.joint.figures.tracking import draw_joint_error, draw_joint_response
from rig.mechanisms.legs.figures.contacts import draw_contacts, stretches_of
from rig.report.data import load_run
from rig.report.figure_data import table_of
from rig.report.frequency_figure import tones_of
from rig.report.repeatability import RevisitedPlace, Visit, places_of
from rig.report.style import paper_style

CONFIGS = Path(__file__).parents[3] / "configs"

CIRCLE = (
    "joint-ideal-circle",
    "reference.tones=[{frequency: 0.2 Hz, laps: 2}, {frequency: 0.5 Hz, laps: 2}]",
    "metrics={}",
)
WALK = ("legs-walk", "reference.landings=2", "reference.speed=6", "approach=0.3 s", "metrics={}")


@pytest.fixture(scope="module")
def run_of(tmp_path_factory):
    """Return ``run_of(experiment, *options)``: a run, made once."""
    made = {}

    def get(name, *options):
        if (name, options) not in made:
            plan = load_plan(name, list(options), configs=CONFIGS)
            out = tmp_path_factory.mktemp("runs")
            made[name, options] = run_experiment(plan, Backend.SIM, out, report=False).path
        return load_run(made[name, options])

    return get


def drawn(draw, run):
    with paper_style():
        return draw(run)


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


class Recorded(SimpleNamespace):
    """A run of invented columns."""

    def trace(self, name):
        return self.columns[name]

    def has(self, *names):
        return all(name in self.columns for name in names)


@pytest.mark.parametrize("seed", range(5))
def test_gain_and_phase_of_tones_are_found_under_noise_and_harmonics(seed):
    random = np.random.default_rng(seed)
    t = np.arange(0.0, 60.0, 2e-3)
    asked, came = np.zeros_like(t), np.zeros_like(t)
    truth, segments = {}, []
    for k, f in enumerate((0.1, 0.25, 0.8)):
        part = (t >= 20.0 * k) & (t < 20.0 * (k + 1))
        gain, phase = random.uniform(0.3, 1.5), random.uniform(-2.5, 0.5)
        angle = 2.0 * math.pi * f * t[part] + random.uniform(0.0, 6.0)
        asked[part] = 0.01 * np.cos(angle)
        came[part] = 0.01 * gain * np.cos(angle + phase) + 0.002 * np.cos(3.0 * angle) + 0.004
        truth[f] = gain, phase
        segments.append(Segment(f"{f:g} Hz", 20.0 * k, 20.0 * (k + 1)))
    came += 1e-4 * random.standard_normal(len(t))
    run = Recorded(
        time=t, segments=[*segments, Segment("hold", 0.0, 1.0)], columns={"r": asked, "x": came}
    )
    found = tones_of(run, "r", "x")
    assert [tone.frequency for tone in found] == list(truth)
    for tone in found:
        gain, phase = truth[tone.frequency]
        assert abs(tone.response) == pytest.approx(gain, abs=2e-3)
        assert np.angle(tone.response * np.exp(-1j * phase)) == pytest.approx(0.0, abs=5e-3)


def test_the_linear_loop_stands_beside_what_was_measured(run_of):
    """Feedforward makes both nearly one; what a linear loop answers is tested with the margins."""
    tones = "reference.tones=[{frequency: 0.4 Hz, periods: 2}, {frequency: 0.8 Hz, periods: 3}]"
    gain, phase = drawn(draw_pair_response, run_of("cylinder-sine", tones, "metrics={}")).axes
    for axes, margin in ((gain, 0.1), (phase, 15.0)):
        f, linear = lines(axes)["linear loop"].get_data()
        asked, found = lines(axes)["position"].get_data()
        assert asked.tolist() == [0.4, 0.8]
        assert f[0] < 0.4 and f[-1] > 0.8
        assert found == pytest.approx(np.interp(asked, f, linear), abs=margin)


def test_each_wire_of_a_circle_is_a_sine(run_of):
    gain, _ = drawn(draw_joint_response, run_of(*CIRCLE)).axes
    wires = [line for label, line in lines(gain).items() if label.startswith("ch")]
    assert len(wires) == 4
    for line in wires:
        assert line.get_ydata() == pytest.approx([1.0, 1.0], abs=0.02)


def test_steps_are_marked_where_the_measures_say(run_of):
    run = run_of("cylinder-ideal-step", "reference.repeats=1")
    (axes,) = drawn(draw_steps, run).axes
    named = [label for label in lines(axes) if label.startswith("step")]
    assert len(named) == 2
    metrics = {metric["name"]: metric["value"] for metric in run.metrics}
    rises = [line.get_xdata()[0] for line in axes.lines if line.get_label() == "_rise"]
    longest = max(high - low for low, high in zip(rises[::2], rises[1::2], strict=True))
    assert longest == pytest.approx(metrics["rise_time"], abs=1e-9)
    peaks = [line.get_ydata()[0] for line in axes.lines if line.get_label() == "_overshoot"]
    assert max(peaks) - 1.0 == pytest.approx(metrics["overshoot"], abs=1e-9)
    sine = run_of("cylinder-sine", "reference.tones=[{frequency: 1 Hz, periods: 2}]", "metrics={}")
    assert drawn(draw_steps, sine) is None


@pytest.mark.parametrize("n", [4, 6, 30])
def test_the_ellipse_holds_95_percent_of_further_visits(n):
    """Drawn visits of a known scatter: how often a further one falls into the region."""
    random = np.random.default_rng(n)
    mix = np.array([[2e-4, 0.0], [1e-4, 3e-5]])
    inside, total = 0, 4000
    for _ in range(total):
        points = random.standard_normal((n + 1, 2)) @ mix.T + [1e-3, 0.0]
        place = RevisitedPlace("a", points[:-1])
        outline = place.region()
        # Inside an ellipse about the origin: its norm by the two half axes is less than one.
        basis = np.linalg.inv(outline[[0, 31]].T)
        inside += bool(np.linalg.norm(basis @ (points[-1] - place.mean)) <= 1.0)
    assert inside / total == pytest.approx(0.95, abs=0.015)


def test_the_interval_on_a_line_is_students():
    ends = np.array([[1.0], [2.0], [4.0], [5.0]]) * 1e-3
    low, high = RevisitedPlace("a", ends).region()[:, 0]
    n, spread = 4, float(np.std(ends, ddof=1))
    wanted = stats.t.ppf(0.975, n - 1) * spread * math.sqrt(1.0 + 1.0 / n)
    assert (low, high) == pytest.approx((-wanted, wanted))


def test_accuracy_and_repeatability_are_those_of_iso_9283():
    place = RevisitedPlace("a", np.array([[1.0, 2.0], [-1.0, 2.0], [0.0, 5.0], [0.0, -1.0]]))
    assert place.accuracy == pytest.approx(2.0)
    assert place.repeatability == pytest.approx(2.0 + 3.0 * np.std([1, 1, 3, 3], ddof=1))


def test_places_gone_to_too_seldom_have_no_scatter():
    visits = [Visit("a", np.zeros(2), np.ones(2))] * 4 + [Visit("b", np.ones(2), np.ones(2))] * 3
    found = places_of(visits, lambda visit: visit.end - visit.target, lambda visit: visit.name)
    assert [place.name for place in found] == ["a"]


def test_poses_that_were_gone_to_again_are_drawn_and_others_are_not(run_of):
    pose, other = "{tilt: 8 deg, azimuth: 0 deg}", "{tilt: 8 deg, azimuth: 90 deg}"
    up = "{tilt: 0 deg}"
    order = ", ".join([up, *[pose, other] * 2, *[other, pose] * 2, up])
    quick = ("reference.rise=0.4 s", "reference.dwell=0.3 s", "metrics={}")
    run = run_of("joint-poses", f"reference.poses=[{order}]", *quick)
    figure = drawn(draw_joint_repeatability, run)
    first, second, _ = figure.axes
    assert first.get_title().startswith("8°, 0°, 4 visits")
    assert second.get_title().startswith("8°, 90°, 4 visits")
    ends = np.array(lines(first)["visits"].get_data())
    assert ends.mean(axis=1) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert "visits" in table_of(figure)
    once = run_of("joint-poses", f"reference.poses=[{up}, {pose}, {up}]", *quick)
    assert drawn(draw_joint_repeatability, once) is None


def test_truth_and_estimate_of_the_marker_have_a_panel_each(run_of):
    figure = drawn(draw_joint_error, run_of(*CIRCLE))
    *_, truth, estimate = figure.axes
    assert "true marker" in lines(truth) and "true marker" not in lines(estimate)
    assert "estimated marker" in lines(estimate)
    assert truth.get_ylim() == estimate.get_ylim()


def test_contacts_are_told_and_a_bounce_of_the_load_is_none():
    t = np.arange(0.0, 4.0, 0.01)
    stands = (t < 1.0) | (t >= 2.0)
    stands[(t >= 2.5) & (t < 2.53)] = False
    found = list(stretches_of(t, stands))
    assert np.ravel(found) == pytest.approx([0.0, 1.0, 2.0, 3.99])
    assert list(stretches_of(t, np.zeros(len(t), bool))) == []


def test_a_foot_is_off_the_ground_in_its_swing(run_of):
    run = run_of(*WALK)
    (axes,) = drawn(draw_contacts, run).axes
    told = [label.get_text() for label in axes.get_yticklabels()]
    assert told == ["right, planned", "right, bears load", "left, planned", "left, bears load"]
    for segment in run.segments:
        if segment.name.startswith("swing"):
            leg = segment.name.split()[1]
            rows = {"right": (-0.2, 0.2), "left": (0.8, 1.2)}[leg]
            middle = 0.5 * (segment.start + segment.end)
            for line in axes.lines:
                (start, end), (row, _) = line.get_data()
                assert not (row in rows and start < middle < end)
