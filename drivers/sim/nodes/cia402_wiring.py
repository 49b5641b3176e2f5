"""From the settings of axes on CiA 402 drives to their simulated forms."""

from drivers.cia402.settings import Cia402Settings
from drivers.sim.axis_lines import correct_axes, perturb_axes
from drivers.sim.direct.axes_of_settings import signed_gear, simulate_axes
from drivers.sim.direct.servos import SimulatedServos
from drivers.sim.direct.stoppable_servos import StoppableServos
from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.drive_contact import wire_contact
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock


def emulate_cia402(of: Installed[Cia402Settings, ServoPort]) -> tuple[EmulatedCia402, ...]:
    """Return one emulated drive per joint, mounted as the driver's settings say."""
    drives = {
        joint: EmulatedCia402(
            f"{of.name}.{joint}",
            drive.node,
            of.plant,
            channel,
            counts_per_turn=drive.counts_per_turn,
            gear=signed_gear(drive),
            zero=drive.offset,
            velocity_units=drive.velocity_units,
            acceleration_units=drive.acceleration_units,
            serial=drive.serial if drive.serial is not None else of.serial or 0,
        )
        for (joint, drive), channel in zip(of.built.joints.items(), of.channels, strict=True)
    }
    contact = of.built.stop_contact
    if contact is not None:
        wire_contact(drives[contact.joint], contact)
    return tuple(drives.values())


def simulate_cia402(of: Installed[Cia402Settings, ServoPort], clock: Clock) -> SimulatedServos:
    """Return simulated joints with the resolution and limits of the drives'."""
    steps = [drive.counts_per_turn for drive in of.settings.joints.values()]
    kind = SimulatedServos if of.settings.stop_contact is None else StoppableServos
    return simulate_axes(of, of.settings.joints, steps, clock, kind)


WIRING = Wiring(emulate_cia402, simulate_cia402, correct_axes, perturb_axes)
