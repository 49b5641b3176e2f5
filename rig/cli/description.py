"""Describe a valid profile or experiment: plain data in SI, and tables for people."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from rig.cli.loops import loop_table
from rig.cli.tables import Table
from rig.config.calibration import HARDWARE
from rig.config.calibration_state import CalibrationState, calibration_states
from rig.hal.formats import format_against, format_quantity

if TYPE_CHECKING:
    from rig.config import DeviceEntry, Profile
    from rig.experiment.frozen import Bound
    from rig.experiment.plan import Plan
    from rig.hal import BusLoad, BusSettings, DriverSettings


def describe_profile(profile: Profile) -> dict[str, Any]:
    """Return what a profile says, in SI; it must have been checked."""
    from rig.assembly import REGISTRY, bus_loads
    from rig.assembly.build import make_unconnected

    loads = bus_loads(profile)
    mechanism = REGISTRY.load("mechanism", profile.mechanism)
    limits = mechanism.limits_of(profile.mechanism_settings)
    made, _ = make_unconnected(profile)
    expected = mechanism.expected_of(made.in_force(profile.mechanism_settings))
    plant = profile.plant
    return {
        "name": profile.name,
        "description": profile.description,
        "mechanism": profile.mechanism,
        "rate": profile.loop.rate,
        "files": [str(path) for path in profile.files],
        "buses": [_bus(name, bus.settings, loads[name]) for name, bus in profile.buses.items()],
        "devices": [_device(name, entry) for name, entry in profile.devices.items()],
        "calibrations": [
            _calibration(state) for state in calibration_states(profile, datetime.now(UTC).date())
        ],
        "limits": [] if limits is None else _quantities(limits),
        "dimensions": dict(mechanism.described(profile.mechanism_settings)),
        "expected": [quantity._asdict() for quantity in expected],
        "controllers": list(profile.controllers),
        "plant": None
        if plant is None
        else {"model": plant.model, "seals": plant.settings.variant()},
    }


def _bus(name: str, settings: BusSettings, load: BusLoad) -> dict[str, Any]:
    return {
        "name": name,
        **settings.endpoint()._asdict(),
        "load": load.total,
        "max_load": settings.max_load,
        "frames": [frame._asdict() for frame in load.frames],
    }


def _device(name: str, entry: DeviceEntry) -> dict[str, Any]:
    calibration = entry.calibration
    settings: DriverSettings = entry.settings
    numbers = {address.name: address.number for address in settings.addresses(name, entry.serial)}
    return {
        "name": name,
        "driver": entry.driver,
        "bus": entry.bus,
        "node": numbers.get(name),  # a chain of joints has one for each
        "serial": entry.serial,
        "calibration": None
        if calibration is None
        else {
            "file": calibration.file,
            "date": calibration.provenance.date,
            "operator": calibration.provenance.operator,
            "valid_until": calibration.provenance.valid_until,
        },
    }


def _calibration(state: CalibrationState) -> dict[str, Any]:
    of = state.calibration.provenance
    return {
        "name": state.name,
        "file": state.calibration.file,
        "state": list(state.problems),
        "on_hardware": of.backend == HARDWARE,
        "remedy": state.remedy if state.problems else None,
        **{
            key: getattr(of, key)
            for key in (
                "procedure", "backend", "seed", "date", "operator", "valid_until",
                "residual_rms", "residual_bound", "unit",
            )
        },
    }  # fmt: skip


def _calibration_row(of: dict[str, Any]) -> tuple[str, ...]:
    residual = "-"
    if of["residual_rms"] is not None:
        residual, bound = format_against(
            of["residual_rms"], of["residual_bound"], of["unit"] or "1"
        )
        residual += f" of {bound}" if bound else ""
    mend = f"; mend it with: {of['remedy']}" if of["state"] else ""
    return (
        of["name"],
        ("; ".join(of["state"]) or _where(of)) + mend,
        of["date"],
        of["valid_until"] or "-",
        residual,
        of["file"],
    )


def _where(of: dict[str, Any]) -> str:
    """Return where a calibration holds: one that was not measured on hardware does not there."""
    return "holds" if of["on_hardware"] else "holds in simulation, refused on hardware"


def _quantities(settings: Any) -> list[dict[str, Any]]:
    """Return every field of a settings dataclass with the unit that it is annotated with."""
    hints = get_type_hints(type(settings), include_extras=True)
    return [
        {
            "name": field.name,
            "value": getattr(settings, field.name),
            "unit": _unit(hints[field.name]),
        }
        for field in dataclasses.fields(settings)
    ]


def _unit(annotation: Any) -> str:
    """Return the first unit in an annotation, also of a tuple's members; else none."""
    from annotated_types import Unit

    for part in (*getattr(annotation, "__metadata__", ()), *get_args(annotation)):
        found = part.unit if isinstance(part, Unit) else _unit(part)
        if found:
            return found
    return ""


def describe_experiment(plan: Plan) -> dict[str, Any]:
    """Return what an experiment says, in SI; it must have been checked."""
    from rig.experiment.measure import Measure
    from rig.experiment.metrics import known_measures
    from rig.experiment.peaks import peaks_of
    from rig.experiment.plan import simulated_otherwise
    from rig.hal.motion import Fact

    experiment, motion = plan.experiment, plan.motion
    known: dict[str, Measure | Fact] = {**known_measures(plan.profile.mechanism), **motion.facts}
    metrics = []
    for name, spec in experiment.metrics.items():
        measure = known[spec.measure or name]
        metrics.append(
            {
                "name": name,
                "measure": spec.measure or name,
                "description": measure.description,
                "segments": spec.segments,
                "unit": measure.unit,
                "max": spec.max,
                "min": spec.min,
            }
        )
    return {
        "name": experiment.name,
        "description": experiment.description,
        "rig": plan.profile.name,
        "controller": experiment.controller,
        "reference": experiment.reference.kind,
        "duration": motion.duration,
        "approach": experiment.approach,
        "files": [str(path) for path in experiment.files],
        "remarks": [note._asdict() for note in motion.remarks],
        "simulated_otherwise": list(simulated_otherwise(plan)),
        "segments": [segment._asdict() for segment in motion.segments],
        "peaks": [peak._asdict() for peak in peaks_of(plan)],
        "metrics": metrics,
    }


def describe_frozen(plan: Plan, bound: Bound) -> dict[str, Any]:
    """Return for how long setpoints may stay as they are, and for how long they would, in SI.

    Parameters
    ----------
    plan : Plan
        Checked.
    bound : Freeze or NoBound or Unfollowed
        What `longest_freeze` has found of it.
    """
    from rig.experiment.slowest import slowest_device
    from rig.hal import Freeze

    slowest = slowest_device(plan.profile)
    return {
        "unknown": None if isinstance(bound, Freeze) else bound.why,
        **(bound._asdict() if isinstance(bound, Freeze) else dict.fromkeys(Freeze._fields)),
        "device": None if slowest is None else slowest._asdict(),
    }


def _frozen_table(frozen: dict[str, Any]) -> Table:
    longest, device = frozen["longest"], frozen["device"]
    if frozen["unknown"]:
        permitted = f"unknown: {frozen['unknown']}"
    elif not frozen["what"]:
        permitted = f"at least {format_quantity(longest, 's')}"
    else:
        at = format_quantity(frozen["at"], "s")
        permitted = f"{format_quantity(longest, 's')}, from {at} on: {frozen['what']}"
    acts = "unknown"
    if device is not None:
        acts = f"{format_quantity(device['after'], 's')} ({device['device']})"
        if longest is not None and device["after"] > longest:
            acts += ", which is too late: refused on hardware"
    rows = [("setpoints may stay for", permitted), ("its devices act after", acts)]
    return Table("if the program dies", ("what", "value"), rows)


def profile_tables(profile: dict[str, Any]) -> list[Table]:
    """Return a described profile as tables."""
    plant = profile["plant"]
    expected = [(of["name"], _text(of["value"], of["unit"])) for of in profile["expected"]]
    dimensions = list(profile["dimensions"].items())
    physics = "-" if plant is None else " ".join(filter(None, (plant["model"], plant["seals"])))
    facts = [
        ("description", profile["description"] or "-"),
        ("mechanism", profile["mechanism"]),
        ("loop rate", format_quantity(profile["rate"], "Hz")),
        ("controllers", ", ".join(profile["controllers"]) or "-"),
        ("plant", physics),
        ("file", profile["files"][0] if profile["files"] else "-"),
    ]
    return [
        Table(f"rig {profile['name']}", ("what", "value"), facts),
        *([Table("dimensions", ("what", "value"), dimensions)] if dimensions else []),
        Table(
            "devices",
            ("device", "driver", "bus", "node", "serial", "calibration"),
            [_device_row(device) for device in profile["devices"]],
        ),
        Table(
            "calibrations",
            ("of", "state", "date", "holds until", "residual rms", "file"),
            [_calibration_row(of) for of in profile["calibrations"]]
            or [("-", "none in force", "-", "-", "-", "-")],
        ),
        *(_load_table(bus) for bus in profile["buses"]),
        Table(
            "limits",
            ("limit", "value"),
            [(limit["name"], _text(limit["value"], limit["unit"])) for limit in profile["limits"]],
        ),
        *(
            [Table("what to expect if a part breaks", ("what", "value"), expected)]
            if expected
            else []
        ),
    ]


def _device_row(device: dict[str, Any]) -> tuple[str, ...]:
    calibration, node, serial = device["calibration"], device["node"], device["serial"]
    return (
        device["name"],
        device["driver"],
        device["bus"] or "-",
        "-" if node is None else f"0x{node:02X}",
        "any" if serial is None else str(serial),
        "none" if calibration is None else f"{calibration['date']}, {calibration['operator']}",
    )


def _load_table(bus: dict[str, Any]) -> Table:
    title = (
        f"bus {bus['name']}: {bus['interface']} {bus['channel']}, {bus['bitrate']} bit/s, "
        f"worst-case load {100 * bus['load']:.1f} % of at most {100 * bus['max_load']:.0f} %"
    )
    rows = [
        (
            frame["name"],
            str(frame["size"]),
            format_quantity(frame["rate"], "Hz"),
            f"{100 * frame['load']:.1f} %",
        )
        for frame in bus["frames"]
    ]
    return Table(title, ("frame", "bytes", "rate", "load"), rows)


def experiment_tables(experiment: dict[str, Any]) -> list[Table]:
    """Return a described experiment as tables."""
    facts = [
        ("description", experiment["description"] or "-"),
        ("rig", experiment["rig"]),
        ("controller", experiment["controller"]),
        ("reference", experiment["reference"]),
        ("approach", format_quantity(experiment["approach"], "s")),
        ("duration", format_quantity(experiment["duration"], "s")),
        *(_peak_row(**peak) for peak in experiment["peaks"]),
    ]
    segments = [
        (s["name"], format_quantity(s["start"], "s"), format_quantity(s["end"], "s"))
        for s in experiment["segments"]
    ]
    remarks = [(note["kind"], note["message"]) for note in experiment["remarks"]]
    remarks += [("in simulation", told) for told in experiment["simulated_otherwise"]]
    metrics = [
        (m["name"], m["description"], m["segments"], _bound(m)) for m in experiment["metrics"]
    ]
    return [
        Table(f"experiment {experiment['name']}", ("what", "value"), facts),
        *([Table("what is known of the motion", ("what", "how"), remarks)] if remarks else []),
        Table("segments", ("segment", "start", "end"), segments),
        Table("metrics", ("metric", "what", "segments", "bound"), metrics),
        *([loop_table(experiment["controller"], experiment["loop"])] if experiment["loop"] else []),
        _frozen_table(experiment["frozen"]),
    ]


def _peak_row(
    what: str, value: float, unit: str, at: float, limit: float | None
) -> tuple[str, str]:
    told = f"{format_quantity(value, unit)} at {format_quantity(at, 's')}"
    beside = "" if limit is None else f"; limit {format_quantity(limit, unit)}"
    return f"peak {what}", told + beside


def _bound(metric: dict[str, Any]) -> str:
    bounds = [
        f"{sign} {_text(metric[kind], metric['unit'])}"
        for kind, sign in (("min", ">="), ("max", "<="))
        if metric[kind] is not None
    ]
    return ", ".join(bounds) or "-"


def _text(value: Any, unit: str) -> str:
    if isinstance(value, tuple | list):
        return " … ".join(_text(item, unit) for item in value)
    if value is None:
        return "-"
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return format_quantity(value, unit or "1") if is_number else str(value)
