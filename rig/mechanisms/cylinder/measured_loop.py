"""The loop of a pair, measured: from a run of the reference ``probe``.

What a law reads in a cycle (position and difference of the pressures) over what it sends in it (the
difference of the setpoints) is the pair, whatever shakes it, as the shake is none of its noise.
Around it a law is known to rounding: it is a program. So one run tells the loop of the law that
ran, and of the same law with other gains.

References
----------
L. Ljung, "System identification", 2nd ed., 1999, section 13.5: joint input-output identification
of what is under control.
"""

from typing import TYPE_CHECKING, Final

import numpy as np

from controllers.cylinder.law import AnyPairLaw, PairLaw
from controllers.cylinder.margins import measured_loop, modelled_loop
from rig.assembly import REGISTRY
from rig.config import load_experiment
from rig.hal import ConfigurationError
from rig.hal.measured_loop import Array, Complex, MeasuredLoop
from rig.mechanisms.cylinder.probe import Probe

if TYPE_CHECKING:
    from rig.report.data import RunData

_FEWEST: Final = 6
"""Glides from which an interval can be told."""
_DRAWN: Final = 200
_SCATTER: Final = 0.5
"""Of a response, beside it: where it is larger, nothing is told."""
_ROUNDING: Final = 1e-6
"""s, of the times of cycles."""
_SIGNALS: Final = {
    "sent": ("applied.agonist", "applied.antagonist"),
    "pressed": ("reading.pressure_agonist", "reading.pressure_antagonist"),
}


def loop_of_run(run: "RunData", law: object) -> MeasuredLoop:
    """Return the loop that a law closes around the pair of a run.

    Parameters
    ----------
    run : RunData
        Of the reference ``probe``.
    law : object
        Made for that rig; it is not changed, and need not be the one that ran.

    Raises
    ------
    ConfigurationError
        The run or the law does not tell it.
    """
    settings = load_experiment(run.folder.path / "experiment.yaml", REGISTRY).reference.settings
    if not isinstance(settings, Probe):
        raise ConfigurationError(f"{run.folder.path}: its reference is no probe")
    if not isinstance(law, PairLaw):
        raise ConfigurationError(f"what is linear of {type(law).__name__} is not known")
    return PairLoop(run, settings).around(law)


class PairLoop:
    """A pair as a run of `Probe` shows it.

    Parameters
    ----------
    run : RunData
        The run.
    probe : Probe
        Its reference.

    Raises
    ------
    ConfigurationError
        It was broken off too early.
    """

    def __init__(self, run: "RunData", probe: Probe) -> None:
        self.frequencies = np.array(probe.harmonics) / probe.period
        t = run.time
        sent, pressed = (run.trace(a) - run.trace(b) for a, b in _SIGNALS.values())
        signals = np.column_stack([sent, run.trace("reading.position"), pressed])
        parts = []
        for segment in run.segments:
            part = (t >= segment.start - _ROUNDING) & (t < segment.end - _ROUNDING)
            if t[-1] >= segment.end:
                parts.append(_phasors(t[part] - segment.start, signals[part], self.frequencies))
        if len(parts) < _FEWEST:
            raise ConfigurationError(
                f"{run.folder.path}: {len(parts)} whole glides, and {_FEWEST} are needed to tell "
                "a loop"
            )
        self._parts: Complex = np.array(parts)

    def around(self, law: AnyPairLaw) -> MeasuredLoop:
        """Return the loop that a law closes around this pair; the law is not changed.

        Raises
        ------
        ConfigurationError
            Noise hides it.
        """
        f = self.frequencies
        one, none = np.ones(len(f), complex), np.zeros(len(f), complex)
        by_position = measured_loop(law, f, np.column_stack([one, none]))
        by_pressure = measured_loop(law, f, np.column_stack([none, one]))

        def loop(parts: Complex) -> Complex:
            sent, came, pressed = np.moveaxis(parts.mean(axis=0), 1, 0)
            return np.asarray((by_position * came + by_pressure * pressed) / sent)

        generator = np.random.default_rng(0)
        count = len(self._parts)
        drawn = [loop(self._parts[generator.integers(0, count, count)]) for _ in range(_DRAWN)]
        found = MeasuredLoop(
            f, loop(self._parts), np.array(drawn), modelled_loop(law, law.model, f)
        )
        try:
            return found.known(_SCATTER)
        except ValueError as error:
            raise ConfigurationError(
                f"{error}: the pair sticks, or swings by itself, while it glides"
            ) from error


def _phasors(t: Array, signals: Array, frequencies: Array) -> Complex:
    """Return the part of each signal at each frequency, beside a straight line; shape (n, 3)."""
    angles = 2.0 * np.pi * np.outer(t, frequencies)
    basis = np.column_stack([np.ones_like(t), t, np.cos(angles), np.sin(angles)])
    found = np.linalg.lstsq(basis, signals, rcond=None)[0][2:]
    count = len(frequencies)
    return np.asarray(found[:count] - 1j * found[count:])
