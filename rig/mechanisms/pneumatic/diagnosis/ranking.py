"""All causes of the last second, the likeliest first, and which of them are worth saying."""

from collections.abc import Iterable
from typing import Final

from rig.mechanisms.pneumatic.diagnosis.causes import Explanation, scales_of
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond
from rig.mechanisms.pneumatic.diagnosis.forces import force_causes, forces_of
from rig.mechanisms.pneumatic.diagnosis.pressures import held_or_let_go
from rig.mechanisms.pneumatic.diagnosis.regulators import slow_or_late

_SURE: Final = 15.0
"""A cause with less gain may be chance."""
_CLEAR: Final = 10.0
"""One that is better by this than any other is the cause (R. E. Kass, A. E. Raftery, "Bayes
factors", J. Am. Stat. Assoc. 90(430), 1995: very strong evidence)."""
_OFF: Final = 1.4
"""Pressures that are off by less than so many times what they scatter show no cause."""


def rank(evidence: LastSecond, others: Iterable[Explanation] = ()) -> list[Explanation]:
    """Return the best figure of each cause and channel, the likeliest first.

    Parameters
    ----------
    evidence : LastSecond
        Of the last second.
    others : iterable of Explanation
        Causes that are a mechanism's own.
    """
    scales = scales_of(evidence)
    trials = [
        *others,
        *(
            trial
            for pair in range(len(evidence.pairs))
            for trial in force_causes(evidence, forces_of(evidence, pair))
        ),
    ]
    if float(scales.left.max()) > (_OFF * evidence.noise) ** 2:
        trials += [*slow_or_late(scales), *held_or_let_go(scales)]
    best: dict[tuple[str, int | None], Explanation] = {}
    for trial in sorted(trials, key=lambda trial: -trial.gain):
        best.setdefault((trial.cause, trial.channel), trial)
    return list(best.values())


def likeliest(ranked: list[Explanation]) -> list[Explanation]:
    """Return the cause that explains it best, two if none is clearly better, or none."""
    sure = [trial for trial in ranked if trial.gain > _SURE]
    return [trial for trial in sure[:2] if trial.gain > sure[0].gain - _CLEAR]
