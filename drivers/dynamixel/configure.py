"""Find one servo, make sure that it is the right one, set it up, and switch its torque on."""

import struct
from math import ceil

from drivers.dynamixel import registers as table
from drivers.dynamixel.client import RegisterClient
from drivers.dynamixel.scaling import AxisScale, encode_position
from drivers.dynamixel.settings import DynamixelAxisSettings, DynamixelSettings


def configure_servo(
    client: RegisterClient, settings: DynamixelSettings, joint: DynamixelAxisSettings
) -> None:
    """Identify and configure a servo; leave it without torque.

    Everything is read back. EEPROM is written only where it differs.

    Parameters
    ----------
    client : RegisterClient
        Of the servo.
    settings : DynamixelSettings
        The device's.
    joint : DynamixelAxisSettings
        The servo's.

    Raises
    ------
    ConnectionFailed
        It does not answer, is another model, has a hardware error, has another zero, or did
        not take a setting.
    """
    _identify(client, settings, joint)
    client.command(table.STATUS_RETURN, table.STATUS_OF_ALL)
    client.write(table.TORQUE_ENABLE, 0)
    client.write(table.BUS_WATCHDOG, 0)
    _check_zero(client, joint)
    client.settle(table.RETURN_DELAY, 0)
    client.settle(table.DRIVE_MODE, 0)  # direction is the profile's, profiles are velocities
    client.settle(table.OPERATING_MODE, table.MODES[settings.mode])
    _limit(client, settings, joint)
    _tune(client, settings, joint)
    if settings.health:
        _map_block(client, settings.block, settings.model_of(joint).indirect_data)


def energise_servo(
    client: RegisterClient, settings: DynamixelSettings, scale: AxisScale, position: float
) -> None:
    """Switch the torque of a servo on, where its joint stands (rad).

    Raises
    ------
    ConnectionFailed
        That is outside the joint's limits, or the servo refuses.
    """
    low, high = settings.joints[client.joint].limits
    margin = abs(scale.step)
    if not low - margin <= position <= high + margin:
        raise client.failed(
            "the joint stands outside its limits; move it by hand",
            register=str(table.PRESENT_POSITION),
            value=f"{position:.4g} rad",
            bound=f"{low:.4g} … {high:.4g} rad",
        )
    if settings.mode != "velocity":
        client.write(settings.goal, encode_position(scale, position))
    client.write(table.TORQUE_ENABLE, 1)


def watchdog_units(watchdog: float) -> int:
    """Return the content of Bus Watchdog for a time, s; at least that long."""
    return min(max(ceil(watchdog / table.WATCHDOG_STEP - 1e-9), 1), table.WATCHDOG_MAX)


def _identify(
    client: RegisterClient, settings: DynamixelSettings, joint: DynamixelAxisSettings
) -> None:
    identity = client.ping()
    expected = settings.model_of(joint)
    if identity.model != expected.number:
        raise client.failed(
            "it is another model than the profile says",
            register="Model Number (0)",
            value=table.describe_model(identity.model),
            bound=table.describe_model(expected.number),
        )
    # Two of a kind say the same of themselves, at the same time; they stand somewhere else.
    client.read(table.PRESENT_POSITION)
    error = client.read(table.HARDWARE_ERROR)
    if error:
        raise client.failed(
            f"it has a hardware error: {table.describe_hardware_error(error)}; find the cause, "
            "then reboot it",
            register=str(table.HARDWARE_ERROR),
            value=f"0x{error:02X}",
        )


def _check_zero(client: RegisterClient, joint: DynamixelAxisSettings) -> None:
    offset = client.read(table.HOMING_OFFSET)
    if offset != joint.homing_offset:
        raise client.failed(
            "its zero was moved since the profile was written",
            register=str(table.HOMING_OFFSET),
            value=f"{offset} counts",
            bound=f"{joint.homing_offset} counts",
        )


def _limit(
    client: RegisterClient, settings: DynamixelSettings, joint: DynamixelAxisSettings
) -> None:
    if settings.mode == "position":
        low, high = joint.servo_range()
        last = table.COUNTS_PER_TURN - 1
        client.settle(table.MIN_POSITION, max(round(low), 0))
        client.settle(table.MAX_POSITION, min(round(high), last))
    client.settle(table.VELOCITY_LIMIT, _capped_speed(joint))
    if settings.current_limit is not None:
        step = settings.model_of(joint).current_step
        client.settle(table.CURRENT_LIMIT, round(settings.current_limit / step))


def _capped_speed(joint: DynamixelAxisSettings) -> int:
    """Return the greatest speed of a servo, in counts of its registers 44 and 112."""
    speed = joint.speed_cap * joint.gear / table.VELOCITY_STEP
    return min(max(ceil(speed), 1), table.MAX_VELOCITY_LIMIT)


def _tune(
    client: RegisterClient, settings: DynamixelSettings, joint: DynamixelAxisSettings
) -> None:
    acceleration = round(settings.profile_acceleration / table.ACCELERATION_STEP)
    velocity = _capped_speed(joint)
    if settings.profile_velocity is not None:
        velocity = round(settings.profile_velocity / table.VELOCITY_STEP)
    client.write(table.PROFILE_ACCELERATION, acceleration)
    client.write(table.PROFILE_VELOCITY, velocity)
    if settings.goal_current is not None:
        step = settings.model_of(joint).current_step
        client.write(table.GOAL_CURRENT, round(settings.goal_current / step))
    gains = settings.gains
    for register, value in (
        (table.POSITION_P, gains.position_p),
        (table.POSITION_I, gains.position_i),
        (table.POSITION_D, gains.position_d),
        (table.VELOCITY_P, gains.velocity_p),
        (table.VELOCITY_I, gains.velocity_i),
        (table.FEEDFORWARD_1, gains.feedforward_1),
        (table.FEEDFORWARD_2, gains.feedforward_2),
    ):
        if value is not None:
            client.write(register, value)


def _map_block(
    client: RegisterClient, block: tuple[table.Register, ...], indirect_data: int
) -> None:
    """Lay what is read each cycle side by side, in the servo's indirect data."""
    addresses = [register.address + k for register in block for k in range(register.size)]
    client.write_bytes(
        table.INDIRECT_ADDRESS,
        struct.pack(f"<{len(addresses)}H", *addresses),
        f"Indirect Address 1 … {len(addresses)} ({table.INDIRECT_ADDRESS})",
    )
    # Older firmware of the small models has its indirect data elsewhere, where 0 is read.
    direct = client.read(table.TEMPERATURE)
    found = client.read_bytes(indirect_data + len(addresses) - 1, 1, "Indirect Data")[0]
    if abs(found - direct) > 1:
        raise client.failed(
            "its indirect data do not show what they should; its firmware may be too old for "
            "health: true",
            register=f"Indirect Data {len(addresses)} ({indirect_data + len(addresses) - 1})",
            value=str(found),
            bound=f"{direct} ± 1, which is {table.TEMPERATURE}",
        )
