"""Defects that are planted into a simulated rig, as a fitter's mistakes would be."""

import dataclasses
import random
from functools import partial

from drivers.sim.nodes.cia401 import EmulatedCia401
from drivers.sim.nodes.cia406 import EmulatedCia406
from rig.assembly import Backend, build_rig


class Watched:
    """A simulated world whose truth is looked at every millisecond."""

    def __init__(self, world, seen):
        self._world = world
        self._seen = seen
        names = [name for name, _ in world.plant.truth_columns]
        self._pressures = [k for k, n in enumerate(names) if n.startswith("pressure_")]
        self._ways = [k for k, n in enumerate(names) if n.startswith(("extension_", "position"))]
        self._first = world.plant.truth()

    def __getattr__(self, name):
        return getattr(self._world, name)

    def advance(self, t):
        while self._world.time < t:
            self._world.advance(min(t, self._world.time + 1e-3))
            truth = self._world.plant.truth()
            for k in self._pressures:
                self._seen["pressure"] = max(self._seen["pressure"], truth[k])
            for k in self._ways:
                self._seen["way"] = max(self._seen["way"], abs(truth[k] - self._first[k]))


class Port:
    """A plant's port with some of it done otherwise."""

    def __init__(self, plant, **otherwise):
        self._plant = plant
        self.__dict__.update(otherwise)

    def __getattr__(self, name):
        return getattr(self._plant, name)


def nodes(rig):
    return {node.name: node for bus in rig.clock.world.buses for node in bus.nodes}


def module(rig):
    return next(node for node in nodes(rig).values() if isinstance(node, EmulatedCia401))


def encoders(rig):
    return [node for node in nodes(rig).values() if isinstance(node, EmulatedCia406)]


def other(channel, count, shift):
    return (channel + shift) % count


def foreign_node(rig, chance):
    bus = chance.choice(rig.clock.world.buses)
    taken = {node.node_id for node in bus.nodes}
    number = chance.choice([n for n in range(1, 127) if n not in taken])
    node = EmulatedCia406("nobody's", number, rig.clock.world.plant, 0)
    node.send = partial(bus._send, node)
    node.listens_anew = bus._listeners.clear
    bus.nodes = (*bus.nodes, node)
    bus._listeners.clear()


def silent_node(rig, chance):
    chance.choice(list(nodes(rig).values())).inject("silent")


def other_kind(rig, chance):
    node = chance.choice(list(nodes(rig).values()))
    node.inject("wrong_device_type", 402)


def refused_error_value(rig, chance):
    module(rig).inject("sdo_abort", 0x6444_00 + chance.randint(1, 2))


def forgotten_watchdog(rig, chance):
    entry = module(rig)._consumer._entries[0]
    entry.changed = lambda: setattr(entry, "value", 0)


def normally_open(rig, chance):
    module(rig)._stop_active_low = False


def stop_not_wired(rig, chance):
    node = module(rig)
    node._read_contacts = lambda: setattr(node._digital_input, "value", node._stop_mask)
    node._digital_input.refresh = node._read_contacts


def with_port(rig, make):
    node = module(rig)
    plant = node._port
    node._port = Port(plant, **make(plant))


def supply_stays_shut(rig, chance):
    with_port(rig, lambda plant: {"set_supply": lambda open: plant.set_supply(False)})


def supply_stays_open(rig, chance):
    with_port(rig, lambda plant: {"set_supply": lambda open: plant.set_supply(True)})
    rig.clock.world.plant.set_supply(True)


def no_dump_valve(rig, chance):
    def stays(plant):
        return {"set_supply": lambda open: plant.set_supply(True) if open else None}

    with_port(rig, stays)


def watchdog_off(rig, chance):
    module(rig)._consumer._lost = lambda node: None


def setpoints_swapped(rig, chance):
    count = len(rig.clock.world.plant.channel_names)
    shift = chance.randrange(1, count)
    with_port(rig, lambda plant: {
        "set_pressure_setpoint": lambda k, p: plant.set_pressure_setpoint(other(k, count, shift), p)
    })  # fmt: skip


def monitors_swapped(rig, chance):
    count = len(rig.clock.world.plant.channel_names)
    shift = chance.randrange(1, count)
    with_port(rig, lambda plant: {"pressure": lambda k: plant.pressure(other(k, count, shift))})


def tubes_swapped(rig, chance):
    setpoints_swapped(rig, random.Random(1))
    monitors_swapped(rig, random.Random(1))


def encoders_swapped(rig, chance):
    first, second = chance.sample(encoders(rig), 2)
    first._channel, second._channel = second._channel, first._channel


def _with_rod(rig, chance, change):
    node = chance.choice(encoders(rig))
    plant = node._port
    home = plant.position(node._channel)
    node._port = Port(
        plant, position=lambda k: home + change * (plant.position(k) - home),
        speed=lambda k: change * plant.speed(k),
    )  # fmt: skip


def encoder_reversed(rig, chance):
    _with_rod(rig, chance, -1.0)


def encoder_scale(rig, chance):
    _with_rod(rig, chance, chance.choice([chance.uniform(0.3, 0.7), chance.uniform(1.5, 1.9)]))


def _factor(chance):
    return chance.choice([chance.uniform(0.35, 0.6), chance.uniform(1.6, 2.0)])


def setpoint_scale(rig, chance):
    channel, factor = chance.randrange(2), _factor(chance)

    def scaled(plant):
        def put(k, pressure):
            plant.set_pressure_setpoint(k, pressure * (factor if k == channel else 1.0))

        return {"set_pressure_setpoint": put}

    with_port(rig, scaled)


def monitor_scale(rig, chance):
    channel, factor = chance.randrange(2), _factor(chance)

    def scaled(plant):
        return {"pressure": lambda k: plant.pressure(k) * (factor if k == channel else 1.0)}

    with_port(rig, scaled)


def sticky_valve(rig, chance):
    plant = rig.clock.world.plant
    plant.inject(f"{chance.choice(plant.channel_names)}.regulator_slow", chance.uniform(4.0, 8.0))


def stuck_valve(rig, chance):
    plant = rig.clock.world.plant
    plant.inject("regulator_stuck", float(chance.randrange(2)))


def leaking_fitting(rig, chance):
    plant = rig.clock.world.plant
    plant.inject(f"{chance.choice(plant.channel_names)}.leak", chance.uniform(2e-11, 2e-10))


def rod_stops_short(rig, chance):
    """Something stands in the way of a rod that is to go further."""
    plant = rig.clock.world.plant
    stroke = plant._common.cylinder.stroke
    jammed, pull = chance.choice(plant.channel_names), plant.pull
    columns = [name for name, _ in plant.truth_columns]
    number, home = columns.index(f"extension_{jammed}"), 0.5 * stroke
    reach = chance.uniform(0.1, 0.3) * stroke

    def blocked(channel, by):
        here = plant.truth()[number]
        if (
            channel != jammed
            or abs(here + by - home) < reach
            or abs(here + by - home) < abs(here - home)
        ):
            pull(channel, by)

    plant.pull = blocked


PLANTED = {
    foreign_node: ("bus", "not in the profile"),
    silent_node: ("bus", "does not answer"),
    other_kind: ("bus", "device profile CiA"),
    refused_error_value: ("identity", "0x6444"),
    forgotten_watchdog: ("identity", "0x1016"),
    normally_open: ("emergency-stop", "normally open"),
    stop_not_wired: ("emergency-stop", "not wired"),
    supply_stays_shut: ("supply", "the supply does not open"),
    supply_stays_open: ("supply", "does not shut"),
    no_dump_valve: ("supply", "dump valve"),
    stuck_valve: ("supply", "stuck"),
    watchdog_off: ("master", "watchdog is off"),
    encoders_swapped: ("sensors", "encoders swapped"),
    encoder_reversed: ("sensors", "direction reversed"),
    encoder_scale: ("sensors", "wrong scale of the encoder"),
    setpoints_swapped: ("actuators", "setpoint wires swapped"),
    monitors_swapped: ("actuators", "monitor wires swapped"),
    tubes_swapped: ("actuators", "tubes swapped"),
    setpoint_scale: ("actuators", "scale of its setpoint"),
    monitor_scale: ("actuators", "wrong scale of its monitor"),
    sticky_valve: ("response", "sticky or slow valve"),
    leaking_fitting: ("leak", "soap water bubbles"),
    rod_stops_short: ("ends", "does not go as far as the profile permits"),
}
"""Where each defect is found, and by which words."""
EARLIER = {setpoint_scale: ("supply", "stop-reaction")}
"""Where it may be found already: regulators as sold let nothing out below some kPa."""


def drawn_unit(profile, seed):
    """Return a profile whose simulated unit differs from it as healthy rigs do."""
    bounds = dataclasses.replace(
        profile.simulation.perturbation,
        setpoint_gain=0.03, setpoint_offset=1.5e3, monitor_gain=0.02, monitor_offset=1.5e3,
        encoder_scale=0.01, encoder_offset=0.5e-3, friction=0.2,
    )  # fmt: skip
    simulation = dataclasses.replace(profile.simulation, perturbation=bounds, seed=seed)
    return dataclasses.replace(profile, simulation=simulation)


def rig_with(seen, plant=None, seed=0):
    """Return what builds a rig with a defect, and looks at the truth of it."""

    def make(its):
        rig = build_rig(its, Backend.VIRTUAL)
        if plant is not None:
            plant(rig, random.Random(f"{plant.__name__} {seed}"))
        rig.clock.world = Watched(rig.clock.world, seen)
        return rig

    return make
