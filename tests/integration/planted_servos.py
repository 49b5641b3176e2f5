"""Defects that are planted into simulated drives, as a fitter's mistakes would be."""

import dataclasses
import math
from functools import partial

from drivers.sim.axis_lines import AxisLines
from drivers.sim.dynamixel.chain import Station
from drivers.sim.dynamixel.servo import EmulatedServo, Mounting
from drivers.sim.nodes.cia402 import EmulatedCia402
from drivers.sim.nodes.cia406 import EmulatedCia406
from drivers.sim.nodes.drive_contact import wire_contact
from drivers.sim.nodes.drive_states import State
from drivers.sim.nodes.odrive import EmulatedOdrive
from drivers.sim.plants.leg_sensors import CELLS


def drives(rig):
    """Return all emulated drives of a rig."""
    found = []
    for bus in rig.clock.world.buses:
        chain = getattr(bus, "chain", None)
        found += [s.servo for s in chain.stations] if chain else list(bus.nodes)
    return [drive for drive in found if isinstance(drive, KINDS)]


KINDS = (EmulatedCia402, EmulatedOdrive, EmulatedServo)


def plug(drive):
    """Return a drive's port to its joint, and what replaces it."""
    encoder = drive.encoder if isinstance(drive, EmulatedServo) else drive._port

    def put(port):
        encoder._port = port

    return encoder._port, put


def line(rig, chance, gain, about=None):
    """Have a joint seen and sent by another straight line about an angle; default: its own."""
    drive = chance.choice(drives(rig))
    port, put = plug(drive)
    channel = drive._channel
    pivot = port.joint_position(channel) if about is None else about
    put(AxisLines(port, {channel: (gain, (1.0 - gain) * pivot)}))
    if isinstance(drive, EmulatedServo):
        drive._reference = drive._plant.joint_position(channel)


def direction_reversed(rig, chance):
    line(rig, chance, -1.0)


def gear_somewhat_wrong(rig, chance):
    line(rig, chance, chance.choice([chance.uniform(0.4, 0.6), chance.uniform(1.7, 2.2)]))


def gear_three_times_too_low(rig, chance):
    line(rig, chance, chance.uniform(0.25, 0.4))


def gear_of_ten(rig, chance):
    line(rig, chance, chance.uniform(0.08, 0.12))


def gear_of_a_hundred(rig, chance):
    line(rig, chance, chance.uniform(0.01, 0.015))


def gear_forgotten(rig, chance):
    line(rig, chance, chance.uniform(50.0, 100.0))


def zero_off(rig, chance):
    drive = chance.choice(drives(rig))
    port, put = plug(drive)
    off = chance.choice([-1.0, 1.0]) * chance.uniform(math.radians(12), math.radians(25))
    put(AxisLines(port, {drive._channel: (1.0, off)}))


def exchanged(rig, chance):
    one, two = chance.sample(drives(rig), 2)
    one._channel, two._channel = two._channel, one._channel


def lies(rig, chance, how, value=None):
    drive = chance.choice(drives(rig))
    if isinstance(drive, EmulatedServo):
        drive.lie(how, value)
    elif isinstance(drive, EmulatedCia402):
        drive._inject_lie(how, value)
    else:
        drive.inject(how, value)


def encoder_mirrored(rig, chance):
    lies(rig, chance, "encoder_mirrored")


def encoder_frozen(rig, chance):
    lies(rig, chance, "encoder_frozen")


def encoder_scale(rig, chance):
    lies(rig, chance, "encoder_scale", chance.choice([0.5, 1.8]) * chance.uniform(0.9, 1.1))


def blocked(rig, chance):
    drive = chance.choice(drives(rig))
    port, put = plug(drive)

    class Stuck:
        def __getattr__(self, name):
            return getattr(port, name)

        def command_joint(self, channel, position, velocity, torque_on):
            port.command_joint(channel, port.joint_position(channel), 0.0, False)

    put(Stuck())


def foreign_node(rig, chance):
    bus = chance.choice([bus for bus in rig.clock.world.buses if hasattr(bus, "nodes")])
    taken = {node.node_id for node in bus.nodes}
    number = chance.choice([n for n in range(1, 63) if n not in taken])
    plant = rig.clock.world.plant
    if isinstance(bus.nodes[0], EmulatedOdrive):
        node = EmulatedOdrive("nobody's", number, plant, 0)
        node._port._port = Nothing()
    else:
        node = EmulatedCia406("nobody's", number, Nothing(), 0)
    node.send = partial(bus._send, node)
    node.listens_anew = bus._listeners.clear
    bus.nodes = (*bus.nodes, node)
    bus._listeners.clear()


def foreign_servo(rig, chance):
    bus = chance.choice([bus for bus in rig.clock.world.buses if hasattr(bus, "chain")])
    stations = bus.chain.stations
    taken = {station.servo.id for station in stations}
    number = chance.choice([n for n in range(1, 252) if n not in taken])
    servo = EmulatedServo(
        number, Nothing(), 0, Mounting(1.0, 0.0), model=1020, indirect_data=224
    )  # fmt: skip
    bus.chain.__init__((*stations, Station(servo)))


class Nothing:
    """A port to nothing."""

    def __getattr__(self, name):
        return lambda *arguments: 0.0


def silent_node(rig, chance):
    node = chance.choice(drives(rig))
    if isinstance(node, EmulatedServo):
        station = next(
            s for bus in rig.clock.world.buses for s in bus.chain.stations if s.servo is node
        )
        station.silence(math.inf)
    else:
        node.inject("silent")


def other_kind(rig, chance):
    chance.choice(drives(rig)).inject("wrong_device_type", 401)


def other_serial(rig, chance):
    """A drive of the same make from another axis of the store."""
    drive = chance.choice(drives(rig))
    if isinstance(drive, EmulatedCia402):
        drive.dictionary.find(0x1018, 4).value += 1
    else:
        drive.serial += 1


def other_model(rig, chance):
    from drivers.sim.dynamixel import control_table as table

    chance.choice(drives(rig)).table[table.MODEL] = 1030


def other_units(rig, chance):
    drive = chance.choice(drives(rig))
    for index in (0x6092, 0x608F):
        entry = drive.dictionary.find(index, 1)
        entry.value = entry.default = entry.value // 2


def torque_cap_not_kept(rig, chance):
    entry = chance.choice(drives(rig)).objects.torque_limit
    entry.changed = lambda: setattr(entry, "value", 0xFFFF)


def stop_code_not_kept(rig, chance):
    entry = chance.choice(drives(rig)).dictionary.find(chance.choice([0x605A, 0x6007, 0x605E]), 0)
    entry.changed = lambda: setattr(entry, "value", 0)


def watchdog_not_kept(rig, chance):
    entry = chance.choice(drives(rig))._consumer._entries[0]
    entry.changed = lambda: setattr(entry, "value", 0)


def watchdog_off(rig, chance):
    drive = chance.choice(drives(rig))
    if isinstance(drive, EmulatedCia402):
        drive._consumer._lost = lambda node: None
    elif isinstance(drive, EmulatedOdrive):
        drive.enable_watchdog = False
    else:
        drive._feed_watchdog = lambda: setattr(drive, "_trips_at", math.inf)


def read_contact(rig):
    """Return who reads the emergency stop, and how its contact is wired."""
    name, contact = next(
        (f"{name}.{entry.settings.stop_contact.joint}", entry.settings.stop_contact)
        for name, entry in rig.profile.devices.items()
        if entry.settings.stop_contact is not None
    )
    return next(drive for drive in drives(rig) if drive.name == name), contact


def normally_open(rig, chance):
    drive, contact = read_contact(rig)
    wire_contact(drive, dataclasses.replace(contact, active_low=not contact.active_low))


def stop_not_wired(rig, chance):
    drive, _ = read_contact(rig)
    for fault in ("emergency_stop", "stop_wire_off"):
        drive.add_fault(fault, lambda value: None, lambda: None)


def stop_ignored(rig, chance):
    """Another firmware's quick stop: the drive goes on."""
    machine = chance.choice(drives(rig)).machine
    command = machine.command

    def hear(word):
        command(0x0F if machine.state is State.ENABLED and word == 0x02 else word)

    machine.command = hear


def joint_stops_short(rig, chance):
    """A cable that is too short stands in the way of a joint."""
    plant = rig.clock.world.plant
    bounds = {
        name: its
        for entry in rig.profile.devices.values()
        for name, its in entry.settings.axis_bounds().items()
    }
    jammed, pull = chance.choice(sorted(bounds)), plant.pull
    _, high, _ = bounds[jammed]
    number = [name for name, _ in plant.truth_columns].index(jammed)
    start = plant.truth()[number]
    end = start + chance.uniform(0.1, 0.5) * (high - start)
    if high - end < math.radians(12.0):
        end = high - math.radians(15.0)

    def caught(channel, by):
        if channel != jammed or by < 0.0 or plant.truth()[number] + by < end:
            pull(channel, by)

    plant.pull = caught


def cell_reversed(rig, chance):
    rig.clock.world.plant.inject(f"{chance.choice(CELLS)}.cell_scale", -1.0)


def cell_scale(rig, chance):
    rig.clock.world.plant.inject(f"{chance.choice(CELLS)}.cell_scale", chance.uniform(1.4, 2.0))


def sensors_swapped(rig, names):
    plant = rig.clock.world.plant
    one, two = (plant.channel_names.index(name) for name in names)
    value = plant.channel_value
    other = {one: two, two: one}
    plant.channel_value = lambda channel: value(other.get(channel, channel))


def cells_swapped(rig, chance):
    sensors_swapped(rig, chance.sample(CELLS, 2))


def lean_axes_swapped(rig, chance):
    sensors_swapped(rig, ("waist_roll", "waist_pitch"))


ANY = {
    silent_node: (("bus", "does not answer"), ("identity", "does not answer")),
    direction_reversed: (("axes", "direction reversed"),),
    gear_somewhat_wrong: (("axes", "wrong scale"), ("hold", "its scale is wrong")),
    gear_three_times_too_low: (("axes", "wrong scale"),),
    gear_of_ten: (("axes", "wrong scale"),),
    gear_of_a_hundred: (("axes", "wrong scale"),),
    gear_forgotten: (("hold", "its scale is wrong"), ("axes", "or its gear is wrong")),
    zero_off: (("ranges", "its zero is wrong"),),
    exchanged: (("ranges", "drives exchanged"), ("axes", "drives exchanged")),
    encoder_mirrored: (("hold", "mirrored"), ("axes", "mirrored")),
    encoder_frozen: (("hold", "frozen"), ("axes", "frozen")),
    encoder_scale: (("axes", "wrong scale"),),
    blocked: (("axes", "does not turn"), ("axes", "it is blocked"), ("hold", "does not follow")),
    watchdog_off: (("master", "watchdog is off"),),
    joint_stops_short: (("ends", "range: "),),
}
ON_CAN = {foreign_node: (("bus", "not in the profile"),)}
ON_CIA402 = {
    other_kind: (("bus", "device profile CiA"),),
    other_serial: (("bus", "serial"),),
    other_units: (("identity", "position unit"),),
    torque_cap_not_kept: (("identity", "0x6072"),),
    stop_code_not_kept: (("identity", "0x60"),),
    watchdog_not_kept: (("identity", "0x1016"),),
    normally_open: (("emergency-stop", "normally open"),),
    stop_not_wired: (("emergency-stop", "not wired"),),
    stop_ignored: (("stop-reaction", "follows setpoints still when it is pressed"),),
}
RIGS = {
    "arm": ANY | ON_CAN | ON_CIA402,
    "arm-odrive": ANY | ON_CAN | {other_serial: (("bus", "serial"),)},
    "legs-can": ANY | ON_CAN | ON_CIA402,
    # Its servos know nothing finer than 0.09 degrees: a hundred times that is no small motion.
    "legs": {plant: found for plant, found in ANY.items() if plant is not gear_of_a_hundred}
    | {
        foreign_servo: (("bus", "not in the profile"),),
        other_model: (("identity", "another model"),),
    },
    "legs-balance": {
        cell_reversed: (("sensors", "direction reversed"),),
        cell_scale: (("sensors", "wrong scale of the sensor"),),
        cells_swapped: (("sensors", "sensors swapped"),),
        lean_axes_swapped: (("sensors", "sensors swapped"),),
    },
}
"""Where each defect may be found, and by which words."""


def prepared(profile, *, torque=False):
    """Return a profile that says of its drives what a lab's would: serials, and torque limits."""

    def said(joint, number):
        known = {field.name for field in dataclasses.fields(joint)}
        wanted = {"serial": 100 + number}
        if torque:
            wanted["max_torque"] = 0.6 * joint.gear
        return dataclasses.replace(joint, **{k: v for k, v in wanted.items() if k in known})

    devices = {}
    for name, entry in profile.devices.items():
        settings = entry.settings
        if not settings.axis_bounds():
            devices[name] = entry
            continue
        joints = {its: said(j, k) for k, (its, j) in enumerate(settings.joints.items())}
        devices[name] = dataclasses.replace(
            entry, settings=dataclasses.replace(settings, joints=joints)
        )
    return dataclasses.replace(profile, devices=devices)
