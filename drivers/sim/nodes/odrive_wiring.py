"""From the settings of axes on ODrives to their simulated forms."""

from drivers.odrive.settings import OdriveEndpoints, OdriveSettings
from drivers.sim.axis_lines import correct_axes, perturb_axes
from drivers.sim.direct.axes_of_settings import signed_gear, simulate_axes
from drivers.sim.direct.servos import SimulatedServos
from drivers.sim.nodes.odrive import (
    SHIPPED_ENCODER,
    SHIPPED_HEARTBEAT,
    STEPS_PER_TURN,
    EmulatedOdrive,
    OdriveBuild,
)
from drivers.sim.servo_port import ServoPort
from drivers.sim.wiring import Installed, Wiring
from rig.hal import Clock


def emulate_odrive(of: Installed[OdriveSettings, ServoPort]) -> tuple[EmulatedOdrive, ...]:
    """Return one emulated axis per joint, mounted and set up as the driver's settings say."""
    settings = of.built
    numbers = settings.endpoints
    # What the driver can write is as the maker ships it; the rest was set by hand.
    writes_heartbeat = numbers is not None and numbers.heartbeat_period is not None
    writes_encoder = numbers is not None and numbers.encoder_period is not None
    return tuple(
        EmulatedOdrive(
            f"{of.name}.{joint}",
            axis.axis,
            of.plant,
            channel,
            OdriveBuild(
                gear=signed_gear(axis),
                zero=axis.offset,
                serial=axis.serial if axis.serial is not None else of.serial or 0,
                watchdog=settings.watchdog if numbers is None else 0.0,
                heartbeat=SHIPPED_HEARTBEAT if writes_heartbeat else settings.heartbeat,
                encoder_period=SHIPPED_ENCODER if writes_encoder else settings.encoder_period,
                endpoints={} if numbers is None else _endpoints(numbers),
            ),
        )
        for (joint, axis), channel in zip(settings.joints.items(), of.channels, strict=True)
    )


def simulate_odrive(of: Installed[OdriveSettings, ServoPort], clock: Clock) -> SimulatedServos:
    """Return simulated joints with the limits of the axes', and the emulated encoders' steps."""
    steps = [float(STEPS_PER_TURN)] * len(of.settings.joints)
    return simulate_axes(of, of.settings.joints, steps, clock)


def _endpoints(numbers: OdriveEndpoints) -> dict[str, int]:
    made = {
        "axis0.config.enable_watchdog": numbers.enable_watchdog,
        "axis0.config.watchdog_timeout": numbers.watchdog_timeout,
        "axis0.config.can.heartbeat_msg_rate_ms": numbers.heartbeat_period,
        "axis0.config.can.encoder_msg_rate_ms": numbers.encoder_period,
        "axis0.controller.config.vel_limit": numbers.speed_limit,
        "axis0.config.motor.current_soft_max": numbers.current_limit,
    }
    return {path: number for path, number in made.items() if number is not None}


WIRING = Wiring(emulate_odrive, simulate_odrive, correct_axes, perturb_axes)
