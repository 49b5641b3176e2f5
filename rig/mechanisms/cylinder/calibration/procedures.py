"""The procedures that a pair shares with other mechanisms on pneumatic cylinders."""

from functools import partial

from rig.mechanisms.cylinder.calibration.pneumatics import PairPneumatics
from rig.mechanisms.pneumatic.calibration.encoders import Encoders
from rig.mechanisms.pneumatic.calibration.leak import Leak
from rig.mechanisms.pneumatic.calibration.regulators import Regulators
from rig.mechanisms.pneumatic.calibration.response import Response
from rig.mechanisms.pneumatic.calibration.valves import Valves
from rig.mechanisms.pneumatic.calibration.wires import WireSweeps

regulators = partial(Regulators, PairPneumatics)
encoders = partial(Encoders, PairPneumatics)
wires = partial(WireSweeps, PairPneumatics)
response = partial(Response, PairPneumatics)
leak = partial(Leak, PairPneumatics)
valves = partial(Valves, PairPneumatics)
