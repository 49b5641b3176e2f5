"""Parameters of the spherical joint's plant.

Sources of the defaults as in `drivers.sim.plants.settings`: C, a catalogue value from general
knowledge; E, an estimate. The joint's own dimensions are the profile's geometry.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Self

from annotated_types import Ge, Gt, Le, Lt, Unit

from drivers.sim.plants.camera_settings import CameraSimulationSettings
from drivers.sim.plants.regulator_settings import (
    RealRegulatorSettings,
    RealTubeSettings,
    RegulatorSettings,
    TubeSettings,
)
from drivers.sim.plants.settings import (
    SEALS,
    CylinderPlantSettings,
    TubedActuatorSettings,
    believed_regulator,
)
from drivers.sim.plants.valve_settings import SpoolSettings, believed_spool


@dataclass(frozen=True, slots=True)
class ContactFriction:
    """Friction coefficients on the ball.

    Parameters
    ----------
    ring, wire : float
        Of the ring in its seat, and of a wire.
    """

    ring: float
    wire: float


CONTACTS = {
    "standard": ContactFriction(0.08, 0.10),  # E: greased ABS
    "low-speed": ContactFriction(0.04, 0.06),  # E: the low-friction rig has better grease, too
}
"""What goes with each kind of seals."""


@dataclass(frozen=True, slots=True)
class RingSettings:
    """The ring with its marker, and how it sits on the ball.

    Parameters
    ----------
    mass : float
        Of ring and marker, kg. E.
    centre_height : float
        Of their centre of gravity above the ball's centre, along the ring's axis, m. E.
    inertia_tilt, inertia_spin : float
        About the ball's centre, across the ring's axis and along it, kg m². E: 30 g of ring
        and 5 g of marker 52 mm out; a wire feels 0.048 kg.
    seat_lever : float
        Mean lever of the seat's friction over the ball's radius. E.
    contact_stiffness, contact_damping : float
        Of what sticks to the ball before it slips (Dahl), ring and wires, N/m and N s/m. E.
    payload, payload_height : float
        Mass that the ring carries on its axis, kg, and its height above the ball's centre, m.
    tilt_stop : float
        Tilt at which the ring meets its mount, rad.
    stop_stiffness, stop_damping : float
        Of that stop, N m/rad and N m s/rad. E.
    """

    mass: Annotated[float, Unit("kg"), Gt(0)] = 0.035
    centre_height: Annotated[float, Unit("m")] = 0.020
    inertia_tilt: Annotated[float, Unit("kg m^2"), Ge(1e-5)] = 3.0e-5
    inertia_spin: Annotated[float, Unit("kg m^2"), Ge(5e-6)] = 1.3e-5
    seat_lever: Annotated[float, Gt(0), Le(1)] = 0.75
    contact_stiffness: Annotated[float, Unit("N/m"), Gt(0), Le(5e5)] = 1.5e5
    contact_damping: Annotated[float, Unit("N s/m"), Ge(0), Le(100)] = 40.0
    payload: Annotated[float, Unit("kg"), Ge(0), Le(5)] = 0.0
    payload_height: Annotated[float, Unit("m"), Ge(0), Le(0.5)] = 0.052
    tilt_stop: Annotated[float, Unit("rad"), Gt(0), Lt(math.pi)] = math.radians(95.0)
    stop_stiffness: Annotated[float, Unit("N m/rad"), Gt(0), Le(500)] = 100.0
    stop_damping: Annotated[float, Unit("N m s/rad"), Ge(0), Le(0.2)] = 0.05

    def loaded(self) -> "RingSettings":
        """Return the ring with its payload as one body."""
        mass = self.mass + self.payload
        moment = self.mass * self.centre_height + self.payload * self.payload_height
        return replace(
            self,
            mass=mass,
            centre_height=moment / mass if self.payload else self.centre_height,
            inertia_tilt=self.inertia_tilt + self.payload * self.payload_height**2,
            payload=0.0,
        )

    def __post_init__(self) -> None:
        if not self.inertia_spin <= 2.0 * self.inertia_tilt:
            raise ValueError(
                f"inertia_spin ({self.inertia_spin:g} kg m^2) is more than twice inertia_tilt "
                f"({self.inertia_tilt:g} kg m^2): no body is like that."
            )


@dataclass(frozen=True, slots=True)
class JointPlantSettings(CylinderPlantSettings):
    """A wide-angle spherical joint on four wires, each pulled by a pneumatic cylinder.

    What feeds the cylinders is a subclass's.

    Parameters
    ----------
    seal_load_scale : float
        Factor on what of the seals' friction grows with the pressure, besides.
    ring_friction_scale, wire_friction_scale : float
        Factors on the friction of the ring in its seat and of the wires on the ball, besides.
    wire_offset : float
        Bound of a wire's deviation from `home`, m; drawn per wire: what homing leaves. E.
    tolerance : float
        Bound of the deviation of each coordinate of an anchor, an adjust point and the marker,
        m; drawn for each. E: machined parts.
    slip : float
        Wire that the fault ``anchor_slipped`` lets through the clamp at the ring, m.
    slack : float
        Wire that the fault ``wire_slack`` lets go at the rod, m.
    ring : RingSettings
        Of the ring.
    camera : CameraSimulationSettings
        What the camera that watches the marker is really like: latency, noise, blur, losses,
        errors of its calibration.
    """

    seal_load_scale: Annotated[float, Ge(0), Le(5)] = 1.0
    ring_friction_scale: Annotated[float, Ge(0), Le(5)] = 1.0
    wire_friction_scale: Annotated[float, Ge(0), Le(5)] = 1.0
    wire_offset: Annotated[float, Unit("m"), Ge(0), Le(5e-3)] = 20e-6
    tolerance: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 20e-6
    slip: Annotated[float, Unit("m"), Ge(0), Le(0.1)] = 2e-3
    slack: Annotated[float, Unit("m"), Ge(0), Le(0.1)] = 10e-3
    ring: RingSettings = field(default_factory=RingSettings)
    camera: CameraSimulationSettings = field(default_factory=CameraSimulationSettings)

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `CylinderPlantSettings.believed`; besides, ``ring_friction``, ``wire_friction``."""
        # By its name: a dataclass with slots is made anew, which an empty super() does not see.
        like = CylinderPlantSettings.believed(self, told)
        nominal, scale = CONTACTS[self.seals], like.friction_scale
        return replace(
            like,
            ring_friction_scale=told["ring_friction"] / (nominal.ring * scale),
            wire_friction_scale=told["wire_friction"] / (nominal.wire * scale),
            wire=replace(like.wire, stiffness=told["wire_stiffness"]),
        )

    def _nominal_friction(self, pressure: float, area: float) -> float:
        """Return what is told as Coulomb friction, N: of two seals; the ball's is told apart."""
        seals = SEALS[self.seals]
        return 2.0 * (seals.coulomb + seals.pressure * pressure)


@dataclass(frozen=True, slots=True)
class SphericalJointPlantSettings(JointPlantSettings):
    """A spherical joint whose cylinders electro-pneumatic regulators feed through tubes.

    Parameters
    ----------
    regulator, tube
        Parameters of the parts, the same for every channel.
    """

    regulator: RegulatorSettings = field(default_factory=RegulatorSettings)
    tube: TubeSettings = field(default_factory=TubeSettings)

    @property
    def feed(self) -> RegulatorSettings:
        """See `CylinderPlantSettings.feed`."""
        return self.regulator

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `JointPlantSettings.believed`; besides, what is told of the regulators."""
        like = JointPlantSettings.believed(self, told)
        return replace(like, regulator=believed_regulator(self.regulator, self.tube, told))


@dataclass(frozen=True, slots=True)
class RealJointSettings(SphericalJointPlantSettings):
    """A spherical joint with regulators, tubes and encoders as catalogues leave them."""

    encoder_noise: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 1e-6
    regulator: RealRegulatorSettings = field(default_factory=RealRegulatorSettings)
    tube: RealTubeSettings = field(default_factory=RealTubeSettings)
    cylinder: TubedActuatorSettings = field(default_factory=TubedActuatorSettings)


@dataclass(frozen=True, slots=True)
class ValveJointSettings(JointPlantSettings):
    """A spherical joint with a proportional valve and a sensor at each chamber.

    Parameters
    ----------
    valve : SpoolSettings
        The valves, the same for every channel.
    """

    encoder_noise: Annotated[float, Unit("m"), Ge(0), Le(1e-3)] = 1e-6
    cylinder: TubedActuatorSettings = field(default_factory=TubedActuatorSettings)
    valve: SpoolSettings = field(default_factory=SpoolSettings)

    @property
    def feed(self) -> SpoolSettings:
        """See `CylinderPlantSettings.feed`."""
        return self.valve

    def believed(self, told: Mapping[str, float]) -> Self:
        """See `JointPlantSettings.believed`; besides, what is told of the spools."""
        like = JointPlantSettings.believed(self, told)
        return replace(like, valve=believed_spool(self.valve, told))
