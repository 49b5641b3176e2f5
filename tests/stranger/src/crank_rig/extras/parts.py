"""What is added to mechanisms of others."""

from rig.hal.parts import Additions

FOR_CYLINDER = Additions(mechanism="cylinder", controllers={"pi": "crank_rig.extras.pi:Pi"})
