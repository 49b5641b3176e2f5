"""How well the legs stand with and without their balance: trials on drawn plants, by their truth.

    python tests/benchmarks/legs_balance.py trials [--count 200] [--first 1000] [--only NAME …]
    python tests/benchmarks/legs_balance.py map [--count 1] [--first 1] [--figure FILE]

``trials`` prints the share of walks in which the robot did not fall, with its interval of 95 %
after Wilson, for pushes of 0.1 to 1 N s to each of four sides, slopes of 3 degrees, a floor 5 mm
lower than planned, and the two latter together with pushes to a side that is drawn. Both robots of
a trial are the same unit under the same push. ``map`` searches the greatest push in 16 directions
that the robot stands, beside what the capture point permits without a step, and draws it.

The loop, the law and the devices are those of `rig run --on sim`; whether the robot fell is what
the plant says.
"""

import argparse
import dataclasses
import math
import sys
from pathlib import Path

import numpy as np

from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan
from rig.runtime.loop import Loop
from rig.runtime.phases import Timings
from rig.runtime.states import RigState, StateMachine
from rig.runtime.stop import StopRequests

CONFIGS = Path(__file__).parents[2] / "configs"
TIMINGS = Timings(energise=0.05, approach=0.5)
WITHOUT = ("legs.stabiliser=null", "legs.sag=null")
SIDES = {"ahead": (1, 0), "left": (0, 1), "back": (-1, 0), "right": (0, -1)}
_AFTER = 1.5
"""How long a robot is looked at after its walk, s."""


def say(line):
    """Print a line at once: a table may take hours."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Unit:
    """A robot as drawn, with its world.

    Parameters
    ----------
    seed : int
        Of everything: masses, frictions, stiffness, latency, and what happens to it.
    slope : tuple of float
        Roll and pitch of the ground, rad.
    """

    def __init__(self, seed, slope=(0.0, 0.0)):
        rng = np.random.default_rng((0xBA1, seed))
        self.seed = seed
        self.side = list(SIDES)[rng.integers(4)]
        self.share = rng.uniform(0.05, 0.95)
        self.impulse = rng.uniform(0.1, 1.0)
        self.delay = rng.uniform(0.0, 0.010)
        self.slope = slope

    def profile(self, profile):
        """Return a profile whose plant is this unit."""
        plant = profile.plant.settings
        settings = dataclasses.replace(
            plant,
            mass_spread=0.10,
            friction_spread=0.20,
            stiffness_spread=0.20,
            ground_roll=self.slope[0],
            ground_pitch=self.slope[1],
            sensors=dataclasses.replace(plant.sensors, delay=self.delay),
        )
        return dataclasses.replace(
            profile,
            plant=dataclasses.replace(profile.plant, settings=settings),
            simulation=dataclasses.replace(profile.simulation, seed=self.seed),
        )


def walk(plan, unit, events=(), until=None):
    """Walk a plan; return whether the robot fell, and the greatest tilt of its waist, rad.

    Parameters
    ----------
    plan : Plan
        What to walk.
    unit : Unit
        Who walks.
    events : sequence of tuple
        Time of the walk (s), fault and value of each thing that happens to the plant.
    until : float, optional
        Time of the walk at which it is broken off, s.
    """
    profile = unit.profile(plan.profile)
    period = profile.loop.period
    begins = TIMINGS.energise + TIMINGS.approach
    ahead = sorted((round((begins + at) / period), fault, value) for at, fault, value in events)
    stop, tilts = StopRequests(), [0.0]

    class Recorder:
        def write(_, cycle, t, row):
            tilts[0] = max(tilts[0], abs(row[roll]), abs(row[roll + 1]))
            while ahead and cycle >= ahead[0][0]:
                _, fault, value = ahead.pop(0)
                plant.inject(fault, value)
            if row[fell] or (until is not None and t > begins + until):
                stop.request()

    rig = build_rig(profile, Backend.SIM)
    plant = rig.clock.world
    names = [name for name, _ in plant.truth_columns]
    roll, fell = (names.index(name) - len(names) for name in ("waist_roll", "fell"))
    states = StateMachine()
    with rig:
        rig.mechanism.attach(plan.controller, plan.motion)
        states.move(RigState.IDLE)
        loop = Loop(
            clock=rig.clock,
            period=period,
            buses=tuple(rig.buses.values()),
            devices=tuple(rig.devices.values()),
            mechanism=rig.mechanism,
            controller=plan.controller,
            states=states,
            truth=rig.truth,
        )
        rig.arm()
        loop.run(
            plan.motion,
            recorder=Recorder(),
            events=lambda *_: None,
            stop=stop,
            timings=TIMINGS,
        )
        if until is None:
            rig.clock.world.advance(rig.clock.now() + _AFTER)
    return bool(plant.truth()[fell]), tilts[0]


def wilson(stood, count):
    """Return the interval of 95 % of a share."""
    z, p = 1.96, stood / count
    middle = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(p * (1 - p) / count + z * z / (4 * count**2))
    return middle - half, middle + half


# What happens in a trial ------------------------------------------------------------------

_LANDS = 1.4
"""In mid-swing of the brisk walk, s: from then on the floor is lower where the foot lands."""
_SLOPE = math.radians(3.0)
_SLOPES = ((0.0, _SLOPE), (0.0, -_SLOPE), (_SLOPE, 0.0), (-_SLOPE, 0.0))
BRISK = ("reference.speed=5", "reference.landings=1", "law=sc-trapezoid")
"""One landing in 3.6 s."""
LOWER = ((_LANDS, "right_floor_lower", 5e-3),)


def push_of(unit, duration, side):
    """Return the push that a unit gets, towards a side or that which is drawn."""
    x, y = SIDES[side or unit.side]
    fault = "forward.push" if x else "left.push"
    return (unit.share * duration, fault, (x + y) * unit.impulse)


def trial(condition, seed, duration):
    """Return the unit of a trial and what happens to it."""
    slope = _SLOPES[seed % 4] if "slope" in condition else (0.0, 0.0)
    unit = Unit(seed, slope)
    events = LOWER if "lower" in condition else ()
    if "push" in condition:
        side = next((side for side in SIDES if condition.endswith(side)), None)
        events = (*events, push_of(unit, duration, side))
    return unit, events


CONDITIONS = (*(f"push {side}" for side in SIDES), "slope", "lower", "slope push", "lower push")


def plans():
    """Return the plan with the corrections and without."""
    options = ["rig=legs-balance", *BRISK]
    return {
        "with": load_plan("legs-walk", options, configs=CONFIGS),
        "without": load_plan("legs-walk", [*options, *WITHOUT], configs=CONFIGS),
    }


def trials(count, first, only):
    """Print each condition's shares."""
    made = plans()
    say("condition    corrections  stood  of   share  interval       mean tilt")
    for condition in only or CONDITIONS:
        stood, tilts = dict.fromkeys(made, 0), {name: [] for name in made}
        for seed in range(first, first + count):
            for name, plan in made.items():
                unit, events = trial(condition, seed, plan.motion.duration)
                fell, tilt = walk(plan, unit, events)
                stood[name] += not fell
                tilts[name].append(tilt)
        for name in made:
            low, high = wilson(stood[name], count)
            tilt = math.degrees(float(np.median(tilts[name])))
            say(
                f"{condition:12} {name:12} {stood[name]:5}  {count:3}  {stood[name] / count:5.3f}  "
                f"{low:.3f} … {high:.3f}  {tilt:.2f} deg"
            )


# The map ----------------------------------------------------------------------------------

PHASES = {"standing": 0.1, "shifting": 0.3, "swinging": 1.5, "landed": 2.7}
"""Instants of the brisk walk, s."""
_TRIES, _MOST = 6, 3.2
"""Of a search by halves, up to so many N s."""


def bound_of(plan, t, angle):
    """Return the impulse per mass that the capture point permits without a step, N s/kg.

    The capture point of the planned motion may be moved to the edge of what the robot stands on.
    """
    from controllers.gait.balance import GRAVITY, support_polygon

    plan = plan.motion.plan
    sample = round(t / plan.period)
    centre = plan.balance.centre
    height = float(centre[sample, 2])
    natural = math.sqrt(GRAVITY / height)
    velocity = (centre[sample + 5, :2] - centre[sample - 5, :2]) / (10.0 * plan.period)
    point = centre[sample, :2] + velocity / natural
    phase = plan.phases[int(plan.phase_number[sample])].phase
    corners = support_polygon(plan.geometry, plan.feet[sample].tolist(), phase.standing)
    way = np.array((math.cos(angle), math.sin(angle)))
    nearest = math.inf
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        edge = there - here
        outward = np.array((edge[1], -edge[0])) / np.linalg.norm(edge)
        towards = float(outward @ way)
        if towards > 1e-9:
            nearest = min(nearest, float(outward @ (here - point)) / towards)
    return nearest * natural


def greatest_push(plan, unit, t, angle):
    """Return the greatest impulse per mass that the robot stands, N s/kg."""
    from drivers.sim.plants import push

    name = f"of {math.degrees(angle):.1f} deg"
    push.LEVEL[name] = (math.cos(angle), math.sin(angle), 0.0)
    low, high = 0.0, _MOST
    for _ in range(_TRIES):
        middle = 0.5 * (low + high)
        fell, _ = walk(plan, unit, [(t, f"{name}.push", middle)], until=t + 2.0)
        low, high = (low, middle) if fell else (middle, high)
    return low / plan.motion.plan.geometry.masses.total


def push_map(count, first, only, figure):
    """Print the greatest pushes beside the bound, for each instant and direction; draw them."""
    made = plans()
    say("phase      deg    bound  with   without  N s/kg; medians of the units")
    rows = {}
    for phase, t in PHASES.items():
        if only and phase not in only:
            continue
        rows[phase] = []
        for step in range(16):
            angle = step * math.pi / 8.0
            found = [
                np.median(
                    [
                        greatest_push(plan, Unit(seed), t, angle)
                        for seed in range(first, first + count)
                    ]
                )
                for plan in made.values()
            ]
            row = (bound_of(made["with"], t, angle), *map(float, found))
            rows[phase].append(row)
            say(f"{phase:10} {22.5 * step:5.1f}  {row[0]:.3f}  {row[1]:.3f}  {row[2]:.3f}")
    for phase, its in rows.items():
        say_shares(phase, np.array(its))
    say_shares("all", np.array([row for its in rows.values() for row in its]))
    if figure is not None:
        draw(rows, figure)


def say_shares(phase, rows):
    """Print how much of the bound is reached, over the directions."""
    for name, pushes in zip(("with", "without"), rows[:, 1:].T, strict=True):
        shares = pushes / rows[:, 0]
        say(
            f"{phase:10} {name:8} of the bound: median {np.median(shares):.2f}, "
            f"{shares.min():.2f} … {shares.max():.2f}, at least 0.8 in {np.sum(shares >= 0.8)} "
            f"of {len(shares)}; {pushes.min():.3f} … {pushes.max():.3f} N s/kg"
        )


def draw(rows, file):
    """Draw a polar map for each instant."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    looks = (
        ("capture point, no step", {"color": "0.5", "linestyle": "--"}),
        ("with the balance", {"color": "#0072b2", "marker": "o", "markersize": 3}),
        ("without", {"color": "#d55e00", "marker": "s", "markersize": 5, "fillstyle": "none"}),
    )
    shape = {"figsize": (3.2 * len(rows), 3.9), "subplot_kw": {"projection": "polar"}}
    drawing, axes = pyplot.subplots(1, len(rows), squeeze=False, layout="constrained", **shape)
    most = max(value for its in rows.values() for row in its for value in row)
    around = np.arange(17) * math.pi / 8.0
    for ax, (phase, its) in zip(axes[0], rows.items(), strict=True):
        for values, (label, look) in zip(np.array([*its, its[0]]).T, looks, strict=True):
            ax.plot(around, values, label=label, **look)
        ax.set_theta_zero_location("N")  # ahead is up, the left on the left
        ax.set_rlim(0.0, 1.05 * most)
        ax.set_rgrids((0.2, 0.4, 0.6), ("0.2", "", "0.6"))  # at 0.4 the curves are
        ax.set_rlabel_position(135.0)
        for label in ax.get_yticklabels():
            label.set(fontsize=8, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})
        ax.set_thetagrids((0, 90, 180, 270), ("ahead", "left", "back", "right"))
        ax.set_title(f"{phase}, {PHASES[phase]:g} s")
    drawing.legend(
        *axes[0, 0].get_legend_handles_labels(),
        title="push that the robot stands, N s/kg",
        loc="outside lower center",
        ncols=3,
    )
    drawing.savefig(file, dpi=90)


def main(arguments):
    """Run one of both."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("trials", "map"))
    parser.add_argument("--count", type=int)
    parser.add_argument("--first", type=int)
    parser.add_argument("--only", nargs="*", default=())
    parser.add_argument("--figure", type=Path, help="of the map")
    of = parser.parse_args(arguments)
    usual = {"trials": (200, 1000), "map": (1, 1)}[of.what]
    count = usual[0] if of.count is None else of.count
    first = usual[1] if of.first is None else of.first
    if of.what == "trials":
        trials(count, first, of.only)
    else:
        push_map(count, first, of.only, of.figure)


if __name__ == "__main__":
    main(sys.argv[1:])
