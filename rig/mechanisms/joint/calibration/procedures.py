"""The procedures that the joint shares with other mechanisms on pneumatic cylinders."""

from functools import partial

from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.joint.calibration.wire_offsets import JointWires
from rig.mechanisms.pneumatic.calibration.encoders import Encoders
from rig.mechanisms.pneumatic.calibration.leak import Leak
from rig.mechanisms.pneumatic.calibration.regulators import Regulators
from rig.mechanisms.pneumatic.calibration.response import Response
from rig.mechanisms.pneumatic.calibration.valves import Valves

regulators = partial(Regulators, JointPneumatics)
encoders = partial(Encoders, JointPneumatics)
wires = partial(JointWires, JointPneumatics)
response = partial(Response, JointPneumatics)
leak = partial(Leak, JointPneumatics)
valves = partial(Valves, JointPneumatics)
