"""Every measure that an experiment may name."""

from rig.experiment.measures.base import Measure
from rig.experiment.measures.pair import PAIR_MEASURES

MEASURES: dict[str, Measure] = {**PAIR_MEASURES}
