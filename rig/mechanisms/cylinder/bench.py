"""The loop of one pair, compiled as a whole with its plant: what `rig tune` tries gains on."""

import math
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, replace
from functools import cache, cached_property
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from controllers.compiled import KernelMemory, let_kernels_call
from controllers.cylinder.law import Output
from controllers.cylinder.margins import margins_around
from controllers.cylinder.numeric_law import AnyNumericLaw, NumericPairLaw
from controllers.cylinder.types import PairModel, PairReference
from rig.hal import ConfigurationError
from rig.hal.bench import Lend, Trial, TuningBench, Unknown
from rig.hal.closed_loop import ClosedLoop
from rig.hal.plant import LentPlant
from rig.mechanisms.cylinder.mechanism import AntagonisticPair
from rig.mechanisms.cylinder.probe import Probe
from rig.mechanisms.cylinder.references import PairMotion, Sine, SineTone, Staircase, Step
from rig.mechanisms.cylinder.settings import CylinderSettings
from rig.mechanisms.cylinder.watch import CHANNELS
from rig.mechanisms.pneumatic.cost import reversals_of
from rig.mechanisms.pneumatic.programme import Programme, lasting_error
from rig.mechanisms.pneumatic.shaken_pair import UNTOLD, ShakenLaw, shaken_margins
from rig.mechanisms.pneumatic.unknowns import UNKNOWNS
from rig.mechanisms.pneumatic.valves.bench import dead_time_of, on_regulators, spools_told
from rig.mechanisms.pneumatic.valves.unknowns import VALVE_UNKNOWNS

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Kernel = Callable[..., int]
LawStep = Callable[..., Output]

_SETTLING: Final = 1.0
"""At base pressure before control begins, s."""
_LOST: Final = 1.5
"""Farther out than this share of the permitted positions, a pair is lost."""
_HOME: Final = PairReference(0.0, 0.0, 0.0)
_PROBED: Final = 0.9
"""Share of the permitted positions that a pair glides over while it is shaken."""
_TRUE, _SETPOINTS, _SHAKEN = 0, slice(1, 3), slice(3, 6)
"""Columns of a trace."""

_Settled = tuple[LentPlant, object, Array, Array]


class PairBench(TuningBench):
    """Closed loops of one pair; see `TuningBench`."""

    unit = "m"
    unknowns: Sequence[Unknown] = UNKNOWNS

    def __init__(
        self,
        settings: CylinderSettings,
        law: type[AnyNumericLaw],
        period: float,
        lend: Lend,
        motions: Sequence[PairMotion] = (),
    ) -> None:
        if not issubclass(law, NumericPairLaw) or not law.tunables:
            raise ConfigurationError(f"{law.__name__} has nothing that could be tuned")
        self._settings, self._law, self._period, self._lend = settings, law, period, lend
        self._model = AntagonisticPair.model_of(settings)
        if settings.valves is not None:
            self.unknowns = VALVE_UNKNOWNS
        self._programme = Programme.of(
            motions or _usual(settings), period, _HOME, AntagonisticPair.approach, tuple
        )
        if lend(self.told(), 0).channels != len(CHANNELS):
            raise ConfigurationError("the profile's plant is no pair of cylinders")
        self._probe = _probe(settings)
        self._limits = _limits(settings, period)
        self._settled: dict[tuple[object, ...], _Settled] = {}
        self.duration = len(self._programme.references) * period

    def told(self) -> dict[str, float]:
        """Return the numbers of the model that laws are told, SI."""
        return {**asdict(self._model), **spools_told(self._settings)}

    def trial(self, chosen: object, true: Mapping[str, float], seed: int) -> Trial:
        """Run a law on a plant; see `TuningBench.trial`."""
        of = self._programme
        trace, cycles = self.run(chosen, true, seed)
        if cycles < len(of.references):
            return Trial({}, 0.0, 0.0, math.inf, cycles / len(of.references))
        errors = trace[:, _TRUE] - of.references[:, 0]
        alarm = round(self._settings.alarms.oscillation.lost / self._period)
        strayed = lasting_error(errors, alarm) / self._settings.limits.following
        reversals = max(reversals_of(asked) for asked in trace[:, _SETPOINTS].T)
        one = errors[:, None]
        return Trial(of.rms(one), of.hunting(one), reversals / self.duration, strayed, 1.0)

    def run(self, chosen: object, true: Mapping[str, float], seed: int) -> tuple[Array, int]:
        """Return what each cycle comes to, and how many it lasted.

        A cycle is the true position (m), both setpoints (Pa), and what tells a loop: their
        difference (Pa), the position (m) and the pressures' difference (Pa) that were read.
        """
        return self._run(self._law_of(chosen), true, seed, self._programme.references)

    def measured(
        self, chosen: object, plants: Sequence[tuple[Mapping[str, float], int]]
    ) -> Sequence[ClosedLoop] | None:
        """Return the margins that are measured on each plant; see `TuningBench.measured`."""
        if self._probe is None:
            return None
        law = self._law_of(chosen)
        shaken = ShakenLaw(law, self._probe.frequencies)
        return [self._measured(law, shaken, self._probe, *plant) for plant in plants]

    def _measured(
        self, law: AnyNumericLaw, shaken: ShakenLaw, probe: Probe, true: Mapping[str, float],
        seed: int,
    ) -> ClosedLoop:  # fmt: skip
        of = self._shake
        trace, cycles = self._run(law, true, seed, of.references)
        if cycles < len(of.references):
            return UNTOLD
        glides = [
            (self._period * np.arange(float(end - first)), trace[first:end, _SHAKEN])
            for _, first, end in of.stretches
        ]
        return shaken_margins(glides, probe.frequencies, shaken)

    @cached_property
    def _shake(self) -> Programme:
        assert self._probe is not None
        approach = AntagonisticPair.approach
        return Programme.of((self._probe,), self._period, _HOME, approach, tuple)

    def _law_of(self, chosen: object) -> AnyNumericLaw:
        return self._law(chosen, self._model, self._period)

    def _run(
        self, law: AnyNumericLaw, true: Mapping[str, float], seed: int, motion: Array
    ) -> tuple[Array, int]:
        lent, *_ = settled = self._settle(true, seed)
        memory, seen, truth = deepcopy(settled[1:])
        difference = seen[2] - seen[3]
        law.numbers.reset(0.5 * (seen[1] - seen[0]), difference)
        numbers = KernelMemory(law.numbers)
        loop = _loop(type(law.numbers).step, numbers.kind, lent.exchange)
        trace = np.zeros((len(motion), 6))
        return trace, loop(numbers.bytes, memory, seen, truth, motion, self._limits, trace)

    def margins(
        self, chosen: object, plants: Sequence[Mapping[str, float]]
    ) -> Sequence[ClosedLoop]:
        """Return the margins around each plant; see `TuningBench.margins`."""
        law = self._law_of(chosen)
        models = [self._model_of(plant) for plant in plants]
        return [ClosedLoop(*margin) for margin in margins_around(law, models)]

    def _model_of(self, plant: Mapping[str, float]) -> PairModel:
        """Return a plant as a linear model has it."""
        numbers = {name: plant[name] for name in PairModel.__dataclass_fields__}
        numbers["regulator_dead_time"] = dead_time_of(self._settings, plant)
        return replace(self._model, **numbers)

    def _settle(self, true: Mapping[str, float], seed: int) -> _Settled:
        """Return a plant at rest at base pressure, what its devices show, and what is true."""
        key = (seed, *sorted(true.items()))
        if key not in self._settled:
            home, lent = self._settings.home, self._lend(true, seed)
            lent = on_regulators(lent, self._settings, CHANNELS, (home, home), self._period)
            seen, truth = np.array([home, home, 0.0, 0.0]), np.zeros(1)
            base = np.full(2, self._settings.base_pressure)
            for _ in range(round(_SETTLING / self._period)):
                lent.exchange(lent.memory, base, seen, truth)
            self._settled[key] = lent, lent.memory, seen, truth
        return self._settled[key]


def _usual(settings: CylinderSettings) -> tuple[PairMotion, ...]:
    """Return what a pair is tuned for if nobody says: slow and fast sines, holds, and steps.

    The fast sine comes first. After slow ones a law has learnt the friction of the pair, and gains
    that need to have learnt it would look good.
    """
    lower, upper = settings.limits.position
    half = 0.25 * (upper - lower)
    middle = 0.5 * (lower + upper)
    tones = (SineTone(0.5, 3), SineTone(0.1, 2), SineTone(0.2, 2))
    small = Sine(0.5 * half, (SineTone(0.25, 2),))
    levels = tuple(middle + share * half for share in (0.0, 0.3, 0.8, 0.0, -0.1))
    steps = Step(half, dwell=2.0, rise=0.5)  # a jump farther than `limits.following` is no motion
    return Sine(half, tones), small, Staircase(levels, rise=0.5, dwell=2.0), steps


def _probe(settings: CylinderSettings) -> Probe | None:
    """Return the glides that tell a loop; None: the permitted positions leave no room for any."""
    try:
        return Probe(_PROBED * min(map(abs, settings.limits.position)))
    except ValueError:
        return None


def _limits(settings: CylinderSettings, period: float) -> Array:
    """Return what the choke point and the program keep to, in the order of the kernel."""
    limits = settings.limits
    lower, upper = limits.pressure
    force, farthest = limits.pair_force / settings.area, max(map(abs, limits.position))
    return np.array([force, lower, upper, limits.pressure_rate * period, _LOST * farthest])


@cache
def _loop(step: LawStep, kind: "np.dtype[np.void]", exchange: Callable[..., None]) -> Kernel:
    """Return the loop of a law on a plant, compiled."""
    import numba

    let_kernels_call()

    def loop(
        law_bytes: Bytes,
        memory: object,
        seen: Array,
        truth: Array,
        motion: Array,
        limits: Array,
        trace: Array,
    ) -> int:  # pragma: no cover - compiled
        law = law_bytes.view(kind)[0]
        most, lower, upper, rate, lost = limits
        setpoints = seen[2:].copy()
        for k in range(len(motion)):
            wanted, velocity, acceleration = motion[k]
            position, difference = 0.5 * (seen[1] - seen[0]), seen[2] - seen[3]
            agonist, antagonist, _, _, _ = step(
                law, position, difference, wanted, velocity, acceleration, 0.0
            )
            apart = agonist - antagonist
            if abs(apart) > most:  # as `AntagonisticPair.limit` and `VectorLimiter` clip it
                mean = 0.5 * (agonist + antagonist)
                agonist = mean + np.copysign(0.5 * most, apart)
                antagonist = 2.0 * mean - agonist
            for channel, asked in enumerate((agonist, antagonist)):
                inside = min(max(asked, lower), upper)
                before = setpoints[channel]
                setpoints[channel] = before + min(max(inside - before, -rate), rate)
            trace[k, 0], trace[k, 1], trace[k, 2] = truth[0], setpoints[0], setpoints[1]
            trace[k, 3], trace[k, 4], trace[k, 5] = (
                setpoints[0] - setpoints[1],
                position,
                difference,
            )
            exchange(memory, setpoints, seen, truth)
            if not abs(truth[0]) < lost:
                return k
        return len(motion)

    return cast(Kernel, numba.njit(error_model="numpy")(loop))
