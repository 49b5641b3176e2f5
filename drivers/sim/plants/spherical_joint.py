"""The wide-angle spherical joint: four pneumatic cylinders turn a ring on a ball by wires."""

import math
from typing import ClassVar

import numpy as np

from drivers.sim.plants.camera_settings import CameraSimulationSettings
from drivers.sim.plants.lending import Kernel, Lending, Memory
from drivers.sim.plants.parameters import scale_seals
from drivers.sim.plants.pneumatic_plant import Array, PneumaticPlant
from drivers.sim.plants.push import Push
from drivers.sim.plants.regulator_plant import RegulatorPlant
from drivers.sim.plants.spherical_joint_kernel import (
    JOINT_STATE,
    WIRE_STATE,
    advance_joint,
    tell_joint,
)
from drivers.sim.plants.spherical_joint_parameters import (
    WIRES,
    JointGeometry,
    check_geometry,
    draw_joint,
    draw_wires,
    home_lengths,
)
from drivers.sim.plants.spherical_joint_settings import (
    JointPlantSettings,
    SphericalJointPlantSettings,
    ValveJointSettings,
)
from drivers.sim.plants.spherical_joint_truth import CHANNELS, TRUTH_COLUMNS
from drivers.sim.plants.spherical_joint_valve_kernel import advance_valve_joint
from drivers.sim.plants.valve_plant import ValvePlant

Vector3 = tuple[float, float, float]

_QW, _PUSH = (list(JOINT_STATE.names or ()).index(name) for name in ("qw", "push_x"))
_LEVEL = {"forward": (1.0, 0.0), "left": (0.0, 1.0)}
"""Directions of a push at the ring, in the ball's axes."""


class SphericalJointBody(PneumaticPlant):
    """Ball, ring and wires of the spherical joint, whatever feeds its cylinders.

    The ring turns about the ball's centre with all three rotations and never leaves the ball:
    its seat is taken as capturing. With the rods at `home` and the ring upright all wires are
    just taut: there it starts, at rest, vented and with the supply closed. A wire that is
    pulled in retracts its rod (Kobayashi and Saito, "Postural control of the wide angle
    spherical joint", eq. (6)): the rod's extension is `home` plus the wire's length less that
    at home, less the wire's stretch.

    Parameters
    ----------
    settings : JointPlantSettings
        Nominal parameters.
    seed : int
        Of the units' deviations and of the monitors' noise: equal seeds give equal runs.
    geometry : JointGeometry
        Nominal dimensions.

    Raises
    ------
    ValueError
        There is no joint of such a geometry.
    """

    channel_names = CHANNELS

    kernel: ClassVar[Kernel]
    """Steps everything that moves."""

    own_faults = (*PneumaticPlant.own_faults, "wire_slack", "anchor_slipped")
    """What `inject` understands; the last two let some wire go (`slack`, `slip`) each time."""

    truth_columns = TRUTH_COLUMNS

    def __init__(self, settings: JointPlantSettings, seed: int, geometry: JointGeometry) -> None:
        check_geometry(geometry)
        self.settings = settings
        units, monitors, shapes = np.random.default_rng(seed).spawn(3)
        self.joint = np.zeros(1, JOINT_STATE)
        self.joint["qw"] = 1.0
        seals = scale_seals(
            settings.seals,
            settings.friction_scale,
            settings.stribeck_scale,
            settings.seal_load_scale,
        )
        self._joint_values = self.joint.view(float)
        push = Push(self._joint_values[_PUSH : _PUSH + 2], _LEVEL, "ring_push")
        super().__init__(
            settings, seals, units=units, monitors=monitors, line=self.joint, push=push
        )
        self.wire_parameters = draw_wires(shapes, settings, geometry)
        self.joint_parameters = draw_joint(shapes, settings, geometry)
        self._free = self.wire_parameters["free"].copy()
        self.wires = np.zeros(WIRES, WIRE_STATE)
        self.wires["length"] = home_lengths(self.wire_parameters, geometry.ball_radius)
        x, y, z = self.joint_parameters[["marker_x", "marker_y", "marker_z"]][0].item()
        self._marker: Vector3 = x, y, z
        self._truth = np.zeros(len(TRUTH_COLUMNS))
        self._integrate(0)

    @property
    def camera(self) -> CameraSimulationSettings:
        """What the camera that watches the marker is really like."""
        return self.settings.camera

    def ring_rotation(self) -> tuple[Vector3, Vector3, Vector3]:
        """Return the rows of the matrix that turns ring coordinates into the ball's."""
        w, x, y, z = self._joint_values[_QW : _QW + 4].tolist()
        return (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )

    def marker_position(self) -> Vector3:
        """Return where the marker is, m, from the ball's centre in the ball's axes."""
        mx, my, mz = self._marker
        x, y, z = (row[0] * mx + row[1] * my + row[2] * mz for row in self.ring_rotation())
        return x, y, z

    def twist(self) -> float:
        """Return the ring's rotation about its axis beyond the shortest tilt to there, rad."""
        w, _, _, z = self._joint_values[_QW : _QW + 4].tolist()
        return math.remainder(2.0 * math.atan2(z, w), 2.0 * math.pi)

    def truth(self) -> tuple[float, ...]:
        """Return what no device measures, as `truth_columns` names it, after the last step."""
        return tuple(self._truth.tolist())

    def lend(
        self, period: float, rod_step: float, pressure_step: float, seed: int
    ) -> tuple[Kernel, Memory]:
        """Return its kernel; see `rig.hal.plant.LendingPlant`. The axes are the marker's."""
        timing = Lending(period, rod_step, pressure_step, seed)
        return self.lend_kernel((type(self).kernel, tell_joint), self._bodies, timing)

    @property
    def _bodies(self) -> tuple[Array, ...]:
        """What the kernel takes before steps and substep."""
        ring = self.joint, self.joint_parameters, self._truth
        wires = self.wires, self.wire_parameters
        return self.channels, self.parameters, self.queues, *wires, *ring

    def _moving(self) -> tuple[Array, ...]:
        return *super()._moving(), self.wires, self._truth

    def _integrate(self, steps: int) -> None:
        type(self).kernel(*self._bodies, steps, self._dt)

    def _break_channel(self, fault: str, channel: int) -> None:
        if fault == "wire_slack":
            self.wire_parameters[channel]["free"] += self.settings.slack
        elif fault == "anchor_slipped":
            self.wire_parameters[channel]["free"] += self.settings.slip
        else:
            super()._break_channel(fault, channel)

    def _repair(self) -> None:
        super()._repair()
        self.wire_parameters["free"] = self._free


class SphericalJointPlant(SphericalJointBody, RegulatorPlant):
    """Physics of the spherical joint on regulators, integrated at 20 kHz.

    Its faults are those of `RegulatorPlant` and `SphericalJointBody`.
    """

    Settings = SphericalJointPlantSettings
    kernel = staticmethod(advance_joint)


class ValveJointPlant(SphericalJointBody, ValvePlant):
    """Physics of the spherical joint on proportional valves, integrated at 20 kHz.

    Its faults are those of `ValvePlant` and `SphericalJointBody`.
    """

    Settings = ValveJointSettings
    kernel = staticmethod(advance_valve_joint)
