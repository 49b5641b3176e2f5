"""What is added to mechanisms of others."""

from rig.hal.parts import Additions

FOR_CYLINDER = Additions(mechanism="cylinder", controllers={"pi": "crank_rig.extras.pi:Pi"})
FOR_ARM = Additions(mechanism="arm", references={"arm-sway": "crank_rig.extras.sway:ArmSway"})
