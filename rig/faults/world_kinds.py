"""What may break in the world: plants, regulators, encoders and cameras.

The simulation says what each of its parts can suffer; a rig gets the rows of the parts that it
has. A row says what must come of it while the rig runs.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from rig.faults.excuses import (
    ON_A_WIRE,
    TUBE,
    drops_a_leg,
    empties_at_once,
    fills_alone,
    has_valves,
    overpowers,
    overpowers_wires,
    pulls_alone,
    topples,
)
from rig.faults.kind import (
    Excuse,
    Expect,
    FaultKind,
    Magnitudes,
    Must,
    Place,
    Sizes,
    either,
    is_felt,
    no_excuse,
    ride,
    safe,
)  # fmt: skip
from rig.faults.lagging import AT_REST_OFF, lags, moves
from rig.faults.stage import Stage
from rig.faults.subject import Subject

_PLANT = "plant"
ALONE = frozenset({*ON_A_WIRE, "pressure"})
"""What a chamber does that no setpoint reaches any more, when all others are vented: it pulls
alone, with what the supply gives, until the mechanical stop bears it."""


def inject(fault: str, stage: Stage, place: Place, sizes: Sizes) -> None:
    """Make a fault happen in the world, of a size or for a time."""
    name = f"{place.axis}.{fault}" if place.axis else fault
    lasts = None if sizes.lasts == float("inf") else sizes.lasts
    value = next((x for x in (place.number, sizes.magnitude, lasts) if x is not None), None)
    stage.world.inject(place.target, name, value)


def in_simulation(kind: FaultKind, place: Place) -> str | None:
    """Return what a profile's ``simulation.faults`` calls a fault; None: they have none like it."""
    apply = kind.apply
    if not (isinstance(apply, partial) and apply.func is inject):
        return None
    name = f"{place.axis}.{apply.args[0]}" if place.axis else apply.args[0]
    value = "" if place.number is None else f", value: {place.number:g}"
    if place.number is None and (kind.magnitude or kind.lasts) is not None:
        value = ", value: …"
    return f"{{device: {place.target}, fault: {name}{value}}}"


def _channels(fault: str, words: Sequence[str], subject: Subject) -> list[Place]:
    """Return a place for each channel of whatever takes a channel's number."""
    return [
        Place(target, f"{target} {channel}", (channel, *words), number=float(number))
        for target, known in subject.knows.items()
        if fault in known
        for number, channel in enumerate(subject.channels.get(target, ()))
    ]


def _devices(fault: str, words: Sequence[str], subject: Subject) -> list[Place]:
    """Return a place for each device, or for each of its axes."""
    places = []
    for target, known in subject.knows.items():
        axes = [name.partition(".")[0] for name in known if name.endswith(f".{fault}")]
        if axes:
            places += [
                Place(target, f"{target} {axis}", (axis, target, *words), axis=axis)
                for axis in axes
            ]
        elif fault in known and "." not in target:
            places.append(Place(target, target, (target, *words)))
    return places


def whole(fault: str, words: Sequence[str], subject: Subject) -> list[Place]:
    """Return the plant as a whole, or the buses."""
    return [
        Place(target, target, (*subject.words_of(target), *words))
        for target, known in subject.knows.items()
        if fault in known
    ]


def _open_contact(times: int, stage: Stage, place: Place, sizes: Sizes) -> None:
    """Open a contact for so long, and close it for so long, so many times."""
    length = sizes.magnitude or 0.0
    now = stage.world.time
    for k in range(times):
        for at, value in ((2 * k, 1.0), (2 * k + 1, 0.0)):
            act = partial(stage.world.inject, place.target, "emergency_stop", value)
            stage.cue(now + at * length, act)


def _outlasts_cycle(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a contact is seen which is open for longer than from one look to the next."""
    return Must.SAFE if (sizes.magnitude or 0.0) > 1.5 * subject.period else Must.EITHER


HARMLESS_PUSH = 0.05
"""N s: moves the mass of the legs by 8 mm/s, and so their capture point by 1.3 mm."""
_ENOUGH_GRIP = 0.3
"""Coefficient of friction."""


def _rides_up_to(most: float) -> Expect:
    """Expect that what is at most so large is ridden through, and that more does no harm."""
    return lambda sizes, subject: Must.RIDE if abs(sizes.magnitude or 0.0) <= most else Must.EITHER


def _is_below_rest(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a pressure is missed which all chambers have where they rest.

    Less what a regulator may be off by, which nobody can tell from it.
    """
    seen = subject.base_pressure - AT_REST_OFF
    return Must.SAFE if (sizes.magnitude or 0.0) < seen else Must.EITHER


HARMLESS_HAND_PUSH = 0.5
"""N s, 5 N for a tenth of a second: what a cable on the hand does."""


def _grips_enough(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a walk needs no more grip than this."""
    return Must.RIDE if (sizes.magnitude or 0.0) >= _ENOUGH_GRIP else Must.EITHER


def _slip(stage: Stage, place: Place, sizes: Sizes) -> Callable[[], None]:
    stage.world.inject(place.target, "floor_slippery", sizes.magnitude)
    return lambda: stage.world.inject(place.target, "floor_grips")


def outlasts_readings(sizes: Sizes, subject: Subject) -> Must:
    """Expect what leaves readings too old to be seen, and what is shorter to be bridged."""
    return Must.SAFE if sizes.lasts > 3.0 * subject.reading_age else Must.EITHER


def row_of(
    name: str,
    what: str,
    places: partial[list[Place]],
    must: Expect = safe,
    within: float = 0.1,
    *,
    fault: str | None = None,
    filling: float = 0.0,
    why: str = "",
    magnitude: Magnitudes | None = None,
    lasts: Magnitudes | None = None,
    forgives: frozenset[str] = frozenset(),
    excuses: Excuse = no_excuse,
) -> FaultKind:
    """Return a row of what the world is told by its own name of the fault, or by `fault`."""
    return FaultKind(
        name=name, what=what, places=places, apply=partial(inject, fault or name), must=must,
        within=within, filling=filling, why=why, magnitude=magnitude, lasts=lasts,
        forgives=forgives, excuses=excuses,
    )  # fmt: skip


def of_plant(name: str, what: str, must: Expect = safe, within: float = 0.1,
              words: Sequence[str] = (), *, filling: float = 0.0, why: str = "",
              forgives: frozenset[str] = frozenset(),
              excuses: Excuse = no_excuse) -> FaultKind:  # fmt: skip
    """Return a fault of a plant that takes a channel's number."""
    places = partial(_channels, name, words)
    return row_of(name, what, places, must, within, filling=filling, why=why, forgives=forgives,
                  excuses=excuses)  # fmt: skip


def of_device(name: str, what: str, must: Expect = safe, within: float = 0.1,
               words: Sequence[str] = (), *, fault: str | None = None, why: str = "",
               filling: float = 0.0,
               magnitude: Magnitudes | None = None, lasts: Magnitudes | None = None,
               forgives: frozenset[str] = frozenset(),
               excuses: Excuse = no_excuse) -> FaultKind:  # fmt: skip
    """Return a fault of a device, or of one of its axes or a plant's channels."""
    places = partial(_devices, fault or name, words)
    return row_of(
        name, what, places, must, within, fault=fault, filling=filling, why=why,
        magnitude=magnitude, lasts=lasts, forgives=forgives, excuses=excuses,
    )  # fmt: skip


_UNTIL_MOVED = 2.0
"""s: a setpoint that rests tells nothing, and moves in the orderly stop at the latest, which a
case asks for after a second and which takes another one."""


def until_moved(kind: FaultKind) -> FaultKind:
    """Return a row with the time in which is to be seen what only motion shows."""
    return replace(kind, within=_UNTIL_MOVED, in_motion=True)


def _is_closed_over(sizes: Sizes, subject: Subject) -> Must:
    """Expect that a chamber sensor is seen which an inner loop of valves relies on."""
    return Must.SAFE if has_valves(subject) else Must.EITHER


_REGULATOR_OFF = 60e3
"""Pa: shows at once, whatever pressures are about to do; less shows while they rest."""
MOMENT = Magnitudes(1e-3, 1.0, "s")
_CAMERA = "the loop closes over the rods; the camera corrects, or records"

PNEUMATIC = (
    of_plant("regulator_stuck", "A regulator holds the pressure that it has.", either, 1.0,
              why="at that pressure the rig may go on for as long as it is wanted"),
    of_device("regulator_stuck_at", "A regulator goes to some pressure and stays there.", either,
               1.0, fault="regulator_stuck", magnitude=Magnitudes(5e3, 450e3, "Pa"),
               why="at a pressure near that which is wanted nothing is amiss; above 50 kPa it "
               "pulls alone when all others are vented, with 9 N and more, until the stop bears it",
               excuses=pulls_alone),
    replace(
        of_device("regulator_slow", "A regulator takes so many times as long.", is_felt(2.5, 3.0),
                  0.5, magnitude=Magnitudes(1.2, 6.0, "1"),
                  why="a little slower tracks a little worse; while its pressure moves so little "
                  "or slowly that it lags by less than regulators are off, nobody can tell"),
        shows=lags),
    of_device("regulator_offset", "A regulator gives another pressure than it is told.",
               is_felt(_REGULATOR_OFF), 1.0, magnitude=Magnitudes(2e3, 120e3, "Pa", signed=True),
               why="the loop closes over the rods; so much a regulator is off by catalogue"),
    of_device("monitor_offset", "A pressure monitor is off.", is_felt(60e3), 1.0, ("monitor",),
               magnitude=Magnitudes(2e3, 120e3, "Pa", signed=True),
               why="the loop closes over the rods; the pressure is judged, not controlled"),
    until_moved(of_device(
        "monitor_frozen", "A pressure monitor repeats its value.", _is_closed_over,
        words=("monitor",),
        why="with regulators the loop closes over the rods, and a pressure may rest")),
    of_device("small_leak", "A chamber leaks.", either, 1.0, fault="leak",
               magnitude=Magnitudes(1e-11, 1e-8, "m^3/(s Pa)"),
               why="a regulator makes up for a leak that is smaller than its flow"),
    replace(until_moved(of_device(
        "leak", "The tube of a chamber is off.", is_felt(TUBE, 2e-8),
        filling=3.5,  # chambers fill and it approaches, before anything moves far enough
        magnitude=Magnitudes(1e-8, 5e-8, "m^3/(s Pa)"),
        why="less than 1.5e-8 m3/(s Pa), or 2e-8 at low pressures, a narrow tube, a "
        "regulator makes up for: the rods stay where they do when nothing leaks; a wider "
        "one empties the chamber before its opponents can be; a monitor at the other end of "
        "the tube shows nothing of it, and while its pair stands, or has moved just before "
        "a stop, nobody can tell",
        excuses=empties_at_once)), shows=moves, is_sudden=True,
        shown_by=("extension_{axis}", "extension_{opposite}")),
    of_plant("regulator_open", "A regulator gives all that the supply has.", safe, 0.2,
              forgives=ALONE),
    of_plant("regulator_closed", "A regulator lets no air in or out.", either, 1.0,
              why="a shut chamber is a spring, and holds where it is", forgives=ALONE),
    of_plant("wire_cut", "A wire breaks.", safe, 0.1, filling=0.5, forgives=ON_A_WIRE),
    of_plant("wire_slack", "A wire has come off its ball and hangs.", safe, 0.5, ("wire",),
              forgives=ON_A_WIRE),  # a chamber that fills takes 0.4 s to pull 10 mm in
    of_plant("anchor_slipped", "A wire has slipped at its anchor.", safe, 0.5, ("wire",),
              forgives=ON_A_WIRE),
    row_of("supply_lost", "The supply falls to another pressure.",
          partial(whole, "supply_lost", ("supply", "regulator")), _is_below_rest, 0.3,
          filling=1.0,  # the setpoints must get above it first
          magnitude=Magnitudes(1e3, 100e3, "Pa"),
          why="a supply above the pressure at rest shows where more than it gives is asked for"),
    of_plant("output_stuck", "An analogue output keeps its value.", either, 1.0,
              ("regulator",), why="as a regulator that holds its pressure, or a spool that "
              "stays where it is", excuses=fills_alone),
    of_plant("wire_break", "The wire of a pressure monitor breaks.", safe, 0.05, ("monitor",)),
)  # fmt: skip

EMERGENCY_STOPS = (
    of_device("emergency_stop", "The emergency stop is pressed.", safe, 0.02,
               ("emergency stop",)),
    of_device("stop_wire_cut", "The wire of the emergency stop's chain breaks.", safe, 0.02,
               ("emergency stop",), fault="emergency_stop"),
    FaultKind(name="emergency_stop_tapped", what="The emergency stop is pressed and let go of.",
              places=partial(_devices, "emergency_stop", ("emergency stop",)),
              apply=partial(_open_contact, 1), must=_outlasts_cycle, within=0.02,
              magnitude=Magnitudes(1e-3, 1.0, "s"),
              why="what is over before the next cycle looks was not there"),
    FaultKind(name="emergency_stop_bounced", what="The contact of the emergency stop bounces.",
              places=partial(_devices, "emergency_stop", ("emergency stop",)),
              apply=partial(_open_contact, 4), must=_outlasts_cycle, within=0.05,
              magnitude=Magnitudes(0.1e-3, 5e-3, "s"),
              why="what is over before the next cycle looks was not there"),
)  # fmt: skip

SENSORS = (
    of_device("encoder_frozen", "An encoder repeats its position.", either, 0.5,
               fault="frozen", why="at rest nobody can tell", lasts=MOMENT),
    of_device("encoder_offset", "An encoder jumps and stays off.", is_felt(4e-3), 0.1,
               ("rod", "wire"), fault="jump", why="wires give so much",
               magnitude=Magnitudes(0.1e-3, 20e-3, "m", signed=True)),
    of_device("encoder_drift", "An encoder's zero wanders.", is_felt(2e-3), 1.5,
               ("rod", "wire"), fault="drift",
               magnitude=Magnitudes(0.1e-3, 10e-3, "m/s", signed=True),
               why="it takes long until a slow drift is more than wires give"),
    of_device("encoder_scale", "An encoder counts so many times the way.", either, 1.0,
               ("rod", "wire"), fault="scale", magnitude=Magnitudes(1.02, 2.0, "1"),
               why="without a way there is nothing to count"),
    of_device("encoder_mirrored", "An encoder counts backwards.", either, 0.5,
               ("rod", "wire"), fault="mirrored", why="without a way there is nothing to count"),
    of_device("encoder_noisy", "An encoder's samples scatter.", either, 0.5, ("rod", "wire"),
               fault="noisy", magnitude=Magnitudes(5e-6, 1e-3, "m"),
               why="noise makes the pressures rough before it makes anything move"),
    of_device("encoder_alarm", "An encoder raises its alarm bit.", safe, 0.1, fault="alarm"),
)  # fmt: skip

NODES = (
    of_device("silent", "A device falls off the bus.", outlasts_readings, 0.1, lasts=MOMENT,
              why="a gap within the age that a reading may have is bridged"),
    of_device("silent_for_good", "A device falls off the bus and stays off.", safe, 0.1,
              fault="silent"),
    of_device("reboot", "A device loses its power for a moment.", safe, 0.1, excuses=drops_a_leg),
    of_device("rebooted", "A servo loses its power for a moment.", safe, 0.1,
               excuses=drops_a_leg),
    of_device("wrong_state", "A device leaves its state unasked.", safe, 0.1),
    of_device("heartbeat_silent", "A device works but sends no heartbeat.", safe, 0.3),
    of_device("emergency", "A device reports an emergency.", safe, 0.05),
    of_device("sdo_silent", "A device answers no SDO.", ride),
)  # fmt: skip

CAMERAS = tuple(
    of_device(f"camera_{name}", what, either, 1.0, ("camera", "marker", "image"), fault=fault,
               why=_CAMERA, magnitude=magnitude, lasts=lasts)
    for name, fault, what, magnitude, lasts in (
        ("blind", "covered", "Something is before the camera.", None, MOMENT),
        ("loses_marker", "lost", "The marker is out of the camera's sight.", None, MOMENT),
        ("sees_another", "swapped", "Another marker is mounted.", None, MOMENT),
        ("stalled", "stalled", "The camera sends no images.", None, MOMENT),
        ("late", "late", "The camera's latency steps up.", Magnitudes(5e-3, 0.5, "s"), None),
    )
)  # fmt: skip

SURROUNDINGS = (
    of_device("push", "Somebody pushes the robot.", _rides_up_to(HARMLESS_PUSH), 1.0,
               ("struck", "from where it was sent", "was sent and does not go", "does not follow"),
               magnitude=Magnitudes(0.01, 5.0, "N s", signed=True), excuses=topples,
               why="nothing measures a push; more than 0.3 N s moves the capture point by 8 mm, "
               "all the margin of a step"),
    of_device("hand_push", "Somebody pushes the arm's hand.", _rides_up_to(HARMLESS_HAND_PUSH),
               1.0, ("struck", "does not follow", "speed above its limit"),
               magnitude=Magnitudes(0.05, 60.0, "N s", signed=True), excuses=overpowers,
               why="nothing measures a push; what it moves the drives bring back, up to 10 N s: "
               "100 N at arm's length are half of the strongest drive's torque"),
    *(
        of_device(f"{part}_push", f"Somebody pushes the {body}.",
                   _rides_up_to(HARMLESS_HAND_PUSH), 1.0,
                   ("pushed", "speed of", "position of the pair", "tilt"),
                   magnitude=Magnitudes(0.05, 10.0, "N s", signed=True), excuses=overpowers_wires,
                   why="nothing measures a push; what it moves the wires bring back: up to "
                   "2 N s, 20 N for a tenth of a second, from chambers of 110 kPa, which have no "
                   "more to give, less from less pressure, and nothing under 50 kPa")
        for part, body in (("carriage", "pair's carriage"), ("ring", "joint's ring"))
    ),
    FaultKind(name="floor_slips", what="The floor loses its grip for a while.",
              places=partial(whole, "floor_slippery", ()), apply=_slip, must=_grips_enough,
              magnitude=Magnitudes(3e-3, 0.8, "1"), lasts=Magnitudes(0.05, 2.0, "s"),
              why="no sensor of the legs sees a foot that slips; so slow a walk bears ice"),
)  # fmt: skip

KINDS = (
    *PNEUMATIC, *EMERGENCY_STOPS, *SENSORS, *CAMERAS, *NODES, *SURROUNDINGS,
)  # fmt: skip
