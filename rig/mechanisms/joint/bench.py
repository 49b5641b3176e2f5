"""The loop of the joint, compiled as a whole with its plant: what `rig tune` tries gains on.

It is the law on encoders and monitors alone. Camera and laps are left out: their loops are slower
by far, and correct the reference of this one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import fields, replace
from functools import cache, cached_property
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from controllers.compiled import KernelMemory, inlined, let_kernels_call
from controllers.cylinder.law import Output
from controllers.cylinder.margins import margins_around
from controllers.cylinder.numeric_law import NumericPairLaw, PairNumbers
from controllers.spherical_joint.geometry import PAIRS
from controllers.spherical_joint.pose_control import (
    POSE_EVERY,
    PoseController,
    PoseControlSettings,
)
from controllers.spherical_joint.pose_kernel import FOUND, PoseNumbers, after, before_natural
from controllers.spherical_joint.types import JointReference
from rig.hal import ConfigurationError
from rig.hal.bench import Lend, Trial, TuningBench, Unknown
from rig.hal.closed_loop import ClosedLoop
from rig.hal.motion import Motion
from rig.hal.plant import LentPlant
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.references.circle import CircleTone, JointCircle
from rig.mechanisms.joint.references.poses import JointPose, JointPoses
from rig.mechanisms.joint.references.probe import JointProbe
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.joint.shaken_ring import shaken_signals
from rig.mechanisms.pneumatic.cost import reversals_of
from rig.mechanisms.pneumatic.programme import Programme, lasting_error
from rig.mechanisms.pneumatic.shaken_pair import UNTOLD, ShakenLaw, shaken_margins
from rig.mechanisms.pneumatic.unknowns import JOINT_UNKNOWNS, UNKNOWNS
from rig.mechanisms.pneumatic.valves.bench import dead_time_of, on_regulators, spools_told
from rig.mechanisms.pneumatic.valves.unknowns import JOINT_VALVE_UNKNOWNS

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Kernel = Callable[..., int]
Step = Callable[..., Output]
AnyPoseController = PoseController[PoseControlSettings]

_SETTLING: Final = 1.0
"""At base pressure before control begins, s."""
_SMALL_TILT: Final = math.radians(20.0)
"""Of the paper's circle, or a third of what the limits permit."""
_UPRIGHT = (0.0, 0.0, 1.0)
_REST = (0.0, 0.0, 0.0)
_HOME: Final = JointReference(_UPRIGHT, _REST, _REST)
_PROBED: Final = 0.77
"""Share of the permitted tilt to which the ring glides while it is shaken."""
_MARKER, _OFF, _ASKED = slice(0, 3), slice(3, 7), slice(7, 11)
_RODS, _READ = slice(11, 15), slice(15, 19)
"""Columns of a trace: the marker, how far each rod is from where the law wants it, setpoints, and
of each rod and pressure what was read."""


class JointBench(TuningBench):
    """Closed loops of the joint; see `TuningBench`. Errors are those of the marker."""

    unit = "m"
    unknowns: Sequence[Unknown] = JOINT_UNKNOWNS

    def __init__(
        self,
        settings: JointSettings,
        law: type[AnyPoseController],
        period: float,
        lend: Lend,
        motions: Sequence[Motion[JointReference]] = (),
    ) -> None:
        if not issubclass(law, PoseController) or not law.tunables:
            raise ConfigurationError(f"{law.__name__} has nothing that could be tuned")
        self._settings, self._law, self._period, self._lend = settings, law, period, lend
        self._model = SphericalJoint.model_of(settings)
        if settings.valves is not None:
            self.unknowns = JOINT_VALVE_UNKNOWNS
        self._programme = Programme.of(
            motions or _usual(settings), period, _HOME, SphericalJoint.approach, _numbers_of
        )
        axes = self._programme.references[:, :3]
        self._probe = _probe(settings)
        self._markers = np.array([settings.geometry.marker(tuple(axis)) for axis in axes])
        if lend(self.told(), 0).channels != len(CHANNELS):
            raise ConfigurationError("the profile's plant is no joint on four wires")
        limits = settings.limits
        lower, upper = limits.pressure
        base = settings.base_pressure
        self._limits = np.array([lower, upper, limits.pressure_rate * period, settings.area, base])
        self._homes = np.array([settings.home + offset for offset in settings.wire_offsets])
        self._settled: dict[tuple[object, ...], tuple[LentPlant, object, Array, Array]] = {}
        self.duration = len(self._programme.references) * period

    def told(self) -> dict[str, float]:
        """Return the numbers of the model that laws are told, SI."""
        numbers = {one.name: getattr(self._model, one.name) for one in fields(self._model)}
        del numbers["geometry"]
        return {**numbers, **spools_told(self._settings)}

    def check(self, chosen: object) -> None:
        """Refuse dithers, and wires or poses of another kind; see `TuningBench.check`."""
        _numbers_of_laws(self._made(chosen))

    def trial(self, chosen: object, true: Mapping[str, float], seed: int) -> Trial:
        """Run a law on a plant; see `TuningBench.trial`."""
        trace, cycles = self.run(chosen, true, seed)
        of = self._programme
        if cycles < len(of.references):
            return Trial({}, 0.0, 0.0, math.inf, cycles / len(of.references))
        errors = trace[:, _MARKER] - self._markers
        alarm = round(self._settings.alarms.oscillation.lost / self._period)
        strayed = max(lasting_error(rod, alarm) for rod in trace[:, _OFF].T)
        reversals = max(reversals_of(asked) for asked in trace[:, _ASKED].T)
        return Trial(
            of.rms(errors), of.hunting(errors), reversals / self.duration,
            strayed / self._settings.limits.following, 1.0,
        )  # fmt: skip

    def run(self, chosen: object, true: Mapping[str, float], seed: int) -> tuple[Array, int]:
        """Return what each cycle comes to, and how many it lasted.

        A cycle is the true place of the marker (m), how far each rod is from where the law wants it
        (m), the setpoints (Pa), and the rods (m, pulled in) and pressures (Pa) that were read.
        """
        return self._run(self._made(chosen), true, seed, self._programme.references)

    def measured(
        self, chosen: object, plants: Sequence[tuple[Mapping[str, float], int]]
    ) -> Sequence[ClosedLoop] | None:
        """Return the margins that are measured on each plant; see `TuningBench.measured`."""
        if self._probe is None:
            return None
        law = self._made(chosen)
        shaken = ShakenLaw(law.pair_law, self._probe.frequencies)
        return [self._measured(law, shaken, self._probe, *plant) for plant in plants]

    def _measured(
        self, law: AnyPoseController, shaken: ShakenLaw, probe: JointProbe,
        true: Mapping[str, float], seed: int,
    ) -> ClosedLoop:  # fmt: skip
        of = self._shake
        trace, cycles = self._run(law, true, seed, of.references)
        if cycles < len(of.references):
            return UNTOLD
        glides = []
        for _, first, end in of.stretches:
            part = trace[first:end]
            signals = shaken_signals(
                self._settings.geometry, part[:, _MARKER], part[:, _RODS], part[:, _ASKED],
                part[:, _READ],
            )  # fmt: skip
            glides.append((self._period * np.arange(float(end - first)), signals))
        return shaken_margins(glides, probe.frequencies, shaken)

    @cached_property
    def _shake(self) -> Programme:
        assert self._probe is not None
        approach = SphericalJoint.approach
        return Programme.of((self._probe,), self._period, _HOME, approach, _numbers_of)

    def _run(
        self, law: AnyPoseController, true: Mapping[str, float], seed: int, motion: Array
    ) -> tuple[Array, int]:
        pose, pairs = _numbers_of_laws(law)
        lent, *_ = settled = self._settle(true, seed)
        memory, seen, truth = deepcopy(settled[1:])
        self._begin(pose, pairs, motion[0], seen)
        laid = [KernelMemory(one) for one in (pose, *pairs)]
        step = type(pairs[0]).step
        loop = _loop(step, laid[0].kind, laid[1].kind, lent.exchange)
        trace = np.zeros((len(motion), 19))
        laws = tuple([one.bytes for one in laid])
        return trace, loop(laws, memory, seen, truth, motion, self._homes, self._limits, trace)

    def _made(self, chosen: object) -> AnyPoseController:
        return self._law(cast(PoseControlSettings, chosen), self._model, self._period)

    def _begin(
        self, pose: PoseNumbers, pairs: Sequence[PairNumbers], reference: Array, seen: Array
    ) -> None:
        """Start the laws of the pairs at what is measured."""
        rods = self._homes - seen[: len(CHANNELS)]
        axis, velocity, acceleration = (tuple(part) for part in reference.reshape(3, 3))
        pressures = tuple(seen[len(CHANNELS) :])
        _, (measured, *_) = before_natural(
            pose, axis, velocity, acceleration, tuple(rods), pressures,
            self._settings.base_pressure, anew=True, starts=True,
        )  # fmt: skip
        pose.reset()
        for numbers, (position, agonist, antagonist) in zip(pairs, measured, strict=True):
            numbers.reset(float(position), float(agonist - antagonist))

    def margins(
        self, chosen: object, plants: Sequence[Mapping[str, float]]
    ) -> Sequence[ClosedLoop]:
        """Return the margins of a pair around each plant; see `TuningBench.margins`."""
        pair = self._made(chosen).pair_law
        models = [replace(pair.model, **self._varied(plant)) for plant in plants]
        return [ClosedLoop(*margin) for margin in margins_around(pair, models)]

    def _varied(self, plant: Mapping[str, float]) -> dict[str, float]:
        """Return what of a plant's numbers a pair's law is told, and may be otherwise."""
        numbers = {name: plant[name] for unknown in UNKNOWNS for name in unknown.numbers}
        return {**numbers, "regulator_dead_time": dead_time_of(self._settings, plant)}

    def _settle(
        self, true: Mapping[str, float], seed: int
    ) -> tuple[LentPlant, object, Array, Array]:
        """Return a plant at rest at base pressure, what its devices show, and what is true."""
        key = (seed, *sorted(true.items()))
        if key not in self._settled:
            lent = on_regulators(
                self._lend(true, seed), self._settings, CHANNELS, self._homes.tolist(), self._period
            )
            seen, truth = np.concatenate([self._homes, np.zeros(len(CHANNELS))]), np.zeros(3)
            base = np.full(len(CHANNELS), self._settings.base_pressure)
            for _ in range(round(_SETTLING / self._period)):
                lent.exchange(lent.memory, base, seen, truth)
            self._settled[key] = lent, lent.memory, seen, truth
        return self._settled[key]


def _usual(settings: JointSettings) -> tuple[Motion[JointReference], ...]:
    """Return what a joint is tuned for if nobody says: the paper's circle, poses near and far."""
    tilt = min(_SMALL_TILT, settings.limits.tilt / 3.0)
    tones = (CircleTone(0.5, 2), CircleTone(0.1, 1), CircleTone(0.2, 1))  # fast: nothing learnt yet
    sides = ((1.0, 0.0), (0.5, 2.0), (2.0, 0.8), (0.3, 4.0), (0.0, 0.0))
    poses = tuple(JointPose(share * tilt, azimuth) for share, azimuth in sides)
    return JointCircle(tilt, tones), JointPoses(poses, rise=1.0, dwell=2.0)


def _probe(settings: JointSettings) -> JointProbe | None:
    """Return the glides that tell a pair's loop; None: the permitted tilt leaves no room for any.

    In the plane of one pair's anchors only that pair moves.
    """
    azimuth = settings.geometry.anchor_angles[PAIRS[0][0]]
    try:
        return JointProbe(_PROBED * settings.limits.tilt, azimuth)
    except ValueError:
        return None


def _numbers_of(reference: JointReference) -> tuple[float, ...]:
    return *reference.axis, *reference.velocity, *reference.acceleration


def _numbers_of_laws(law: AnyPoseController) -> tuple[PoseNumbers, tuple[PairNumbers, ...]]:
    """Return the numbers of a law's steps, and of the laws of its pairs.

    Raises
    ------
    ValueError
        Some of it is not compiled here.
    """
    pose = law.numbers
    if pose is None:
        raise ValueError("gains are tried with exact wires and the natural pose alone")
    if law.shakes:
        raise ValueError(
            "gains are tried without dither: dither.amplitude and path_dither.force have to be 0"
        )
    pairs = [one.numbers for one in law.pair_laws if isinstance(one, NumericPairLaw)]
    if len(pairs) != len(law.pair_laws):
        raise ValueError(f"{type(law).__name__} has laws of pairs that are not compiled")
    return pose, tuple(pairs)


@inlined
def _limited(asked: float, before: float, limits: Array) -> float:
    """Return what `VectorLimiter` makes of a setpoint."""
    lower, upper, rate, _, _ = limits
    inside: float = min(max(asked, lower), upper)
    if abs(inside - before) > rate:
        inside = before + math.copysign(rate, inside - before)
    return inside


@cache
def _loop(
    step: Step,
    pose_kind: "np.dtype[np.void]",
    pair_kind: "np.dtype[np.void]",
    exchange: Callable[..., None],
) -> Kernel:
    """Return the loop of a law on a plant, compiled."""
    import numba

    let_kernels_call()

    def loop(
        laws: tuple[Bytes, Bytes, Bytes],
        memory: object,
        seen: Array,
        truth: Array,
        motion: Array,
        homes: Array,
        limits: Array,
        trace: Array,
    ) -> int:  # pragma: no cover - compiled
        pose = laws[0].view(pose_kind)[0]
        one, other = laws[1].view(pair_kind)[0], laws[2].view(pair_kind)[0]
        lower, upper, _, area, base = limits
        setpoints = np.minimum(np.maximum(seen[4:], lower), upper)
        for k in range(len(motion)):
            x, y, z, dx, dy, dz, ddx, ddy, ddz = motion[k]
            a, b, c, d = homes - seen[:4]
            p, q, r, s = seen[4:]
            rods, anew, starts = (a, b, c, d), k % POSE_EVERY == 0, k == 0
            how, (measured, goals, friction, wanted, _, _, _) = before_natural(
                pose, (x, y, z), (dx, dy, dz), (ddx, ddy, ddz), rods, (p, q, r, s),
                base, anew, starts,
            )  # fmt: skip
            if how != FOUND:
                return k
            at, agonist, antagonist = measured[0]
            goal, speed, rise = goals[0]
            force, back, _, _, _ = step(
                one, at, agonist - antagonist, goal, speed, rise, friction[0]
            )
            at, agonist, antagonist = measured[1]
            goal, speed, rise = goals[1]
            over, under, _, _, _ = step(
                other, at, agonist - antagonist, goal, speed, rise, friction[1]
            )
            asked = after(pose, area * (force - back), area * (over - under), 0.0)
            for channel in range(4):
                setpoints[channel] = _limited(asked[channel], setpoints[channel], limits)
                trace[k, 3 + channel] = wanted[channel] - rods[channel]
            trace[k, :3], trace[k, 7:11] = truth, setpoints
            trace[k, 11], trace[k, 12], trace[k, 13], trace[k, 14] = rods
            trace[k, 15:] = seen[4:]
            exchange(memory, setpoints, seen, truth)
        return len(motion)

    return cast(Kernel, numba.njit(error_model="numpy")(loop))
